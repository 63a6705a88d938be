#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "Adapters/OpenCv/ImageMasks.h"
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

}  // namespace
