#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "Adapters/OpenCv/ImageMasks.h"
#include "Adapters/OpenCv/OrganSegmentation.h"
#include "Core/Errors.h"
#include "Core/Features.h"
#include "SyntheticVideo.h"

using namespace kerf;
using kerf::test::MakeFrame;
using kerf::test::Tissue;

namespace {

double Overlap(const Image& mask, const cv::Mat& truth) {
  const cv::Mat found = ViewOf(mask);
  const double both = cv::countNonZero(found & truth), either = cv::countNonZero(found | truth);
  return either > 0 ? both / either : 1.0;
}

TEST(Masks, ShaftFromTheBorderIsAnInstrument) {
  cv::Mat picture = Tissue(640, 360, 1);
  cv::Mat truth(360, 640, CV_8U, cv::Scalar(0));
  cv::line(truth, {640, 360}, {420, 200}, cv::Scalar(255), 30);
  picture.setTo(cv::Scalar(40, 34, 32), truth);
  EXPECT_GT(Overlap(InstrumentMask(MakeFrame(0, picture)), truth), 0.8);
}

TEST(Masks, PlainTissueHasNone) {
  const Frame frame = MakeFrame(0, Tissue(640, 360, 2));
  EXPECT_EQ(cv::countNonZero(ViewOf(InstrumentMask(frame))), 0);
  EXPECT_EQ(cv::countNonZero(ViewOf(SpecularMask(frame))), 0);
}

TEST(Masks, HighlightIsNoInstrument) {
  cv::Mat picture = Tissue(640, 360, 3);
  cv::Mat truth(360, 640, CV_8U, cv::Scalar(0));
  cv::ellipse(truth, {300, 180}, {60, 30}, 20, 0, 360, cv::Scalar(255), cv::FILLED);
  picture.setTo(cv::Scalar(250, 252, 255), truth);
  const Frame frame = MakeFrame(0, picture);
  EXPECT_GT(Overlap(SpecularMask(frame), truth), 0.85);
  EXPECT_EQ(cv::countNonZero(ViewOf(InstrumentMask(frame)) & truth), 0);
}

TEST(Masks, NoImageNoMask) {
  EXPECT_TRUE(InstrumentMask(Frame{}).data.empty());
  EXPECT_TRUE(SpecularMask(Frame{}).data.empty());
}

/// A reddish organ on a greenish ground with a wedge cut out of it, and a model that is uncut and
/// 10 px off.
struct OrganScene {
  cv::Mat picture, truth;
  Image model;
};
OrganScene MakeOrgan() {
  OrganScene scene;
  const cv::Mat tissue = Tissue(640, 360, 5);
  cv::Mat ground = Tissue(640, 360, 6), channels[3];
  cv::split(ground, channels);
  cv::merge(std::vector<cv::Mat>{channels[0], channels[2], channels[2] * 0.8}, scene.picture);
  scene.truth = cv::Mat(360, 640, CV_8U, cv::Scalar(0));
  cv::ellipse(scene.truth, {320, 180}, {180, 100}, 10, 0, 360, cv::Scalar(255), cv::FILLED);
  cv::Mat uncut;
  cv::warpAffine(scene.truth, uncut, cv::Matx23d(1, 0, 8, 0, 1, -6), scene.truth.size(),
                 cv::INTER_NEAREST);
  scene.model = ToImage(uncut);
  const std::vector<cv::Point> wedge{{320, 180}, {290, 300}, {350, 300}};
  cv::fillConvexPoly(scene.truth, wedge, cv::Scalar(0));
  tissue.copyTo(scene.picture, scene.truth);
  return scene;
}

TEST(OrganSilhouette, FollowsThePictureNotTheModel) {
  const OrganScene scene = MakeOrgan();
  const double model = Overlap(scene.model, scene.truth);
  const double found = Overlap(OrganMask(MakeFrame(0, scene.picture), scene.model), scene.truth);
  EXPECT_LT(model, 0.9);
  EXPECT_GT(found, 0.96);
}

TEST(OrganSilhouette, WhatAnInstrumentHidesIsMarked) {
  OrganScene scene = MakeOrgan();
  const cv::Rect clamp(440, 120, 200, 120);  // over the organ's right end and on to the border
  scene.picture(clamp).setTo(cv::Scalar(60, 58, 56));
  const Image found = OrganMask(MakeFrame(0, scene.picture), scene.model);
  const cv::Mat mask = ViewOf(found);
  EXPECT_EQ(mask.at<std::uint8_t>(180, 470), OrganSegmenter::kHidden);
  EXPECT_EQ(mask.at<std::uint8_t>(180, 437), OrganSegmenter::kHidden) << "its rim belongs to it";
  EXPECT_EQ(mask.at<std::uint8_t>(180, 400), OrganSegmenter::kOrgan);
  EXPECT_EQ(mask.at<std::uint8_t>(20, 100), OrganSegmenter::kGround);
}

TEST(OrganSilhouette, ColoursThatDoNotTellLeaveTheModel) {
  const OrganScene scene = MakeOrgan();
  const Frame all_tissue = MakeFrame(0, Tissue(640, 360, 5));
  EXPECT_GT(Overlap(OrganMask(all_tissue, scene.model), ViewOf(scene.model)), 0.85);
  EXPECT_EQ(OrganMask(Frame{}, scene.model).data, scene.model.data);
  Image empty = scene.model;
  std::fill(empty.data.begin(), empty.data.end(), 0);
  EXPECT_EQ(OrganMask(all_tissue, empty).data, empty.data);
  EXPECT_THROW(OrganMask(all_tissue, Image{4, 4, 1, std::vector<std::uint8_t>(16)}), InputError);
}

}  // namespace
