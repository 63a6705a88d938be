#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgcodecs.hpp>

#include "Adapters/OpenCv/CameraCalibration.h"
#include "Core/Errors.h"
#include "SyntheticVideo.h"

using namespace kerf;
using kerf::test::Scratch;

namespace {

constexpr int kColumns = 9, kRows = 7;
constexpr double kSquare_mm = 10, kPixelsPerMm = 8;

CameraModel Lens() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 612;
  camera.fy = 615;
  camera.cx = 327;
  camera.cy = 236;
  camera.distortion = {-0.21, 0.07, 8e-4, -5e-4, 0};
  return camera;
}

CalibrationBoard Board(BoardKind kind) {
  CalibrationBoard board;
  board.kind = kind;
  board.columns = kColumns;
  board.rows = kRows;
  board.square_mm = kSquare_mm;
  board.marker_mm = 7.5;
  return board;
}

/// The print at 8 px a millimetre, with a white border of one square.
cv::Mat Print(BoardKind kind) {
  const int square = static_cast<int>(kSquare_mm * kPixelsPerMm);
  cv::Mat inner(kRows * square, kColumns * square, CV_8U, cv::Scalar(255));
  if (kind == BoardKind::Charuco) {
    const auto board =
        cv::aruco::CharucoBoard::create(kColumns, kRows, static_cast<float>(kSquare_mm), 7.5F,
                                        cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50));
    board->draw(inner.size(), inner, 0, 1);
  } else {
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kColumns; ++x)
        if ((x + y) % 2 == 0) inner(cv::Rect(x * square, y * square, square, square)).setTo(0);
  }
  cv::Mat print;
  cv::copyMakeBorder(inner, print, square, square, square, square, cv::BORDER_CONSTANT,
                     cv::Scalar(255));
  return print;
}

/// What the camera sees of the print, every pixel's ray cut with the board's plane, twice
/// supersampled.
cv::Mat Photograph(const cv::Mat& print, int view) {
  CameraModel camera = Lens();
  const double tilt_x = 0.5 * std::sin(1.7 * view), tilt_y = 0.5 * std::cos(2.3 * view);
  const double du = 30 * std::sin(2.1 * view + 1), dv = 18 * std::cos(1.3 * view);
  camera.camera_from_world =
      Eigen::Translation3d(du, dv, 130 + 20 * std::sin(view)) *
      Eigen::AngleAxisd(tilt_x, Vec3::UnitX()) * Eigen::AngleAxisd(tilt_y, Vec3::UnitY()) *
      Eigen::AngleAxisd(0.3 * view, Vec3::UnitZ()) *
      Eigen::Translation3d(-kColumns * kSquare_mm / 2, -kRows * kSquare_mm / 2, 0);
  const int factor = 2;
  cv::Mat map(factor * camera.height, factor * camera.width, CV_32FC2);
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x) {
      const Ray ray = camera.RayThrough(Vec2((x + 0.5) / factor - 0.5, (y + 0.5) / factor - 0.5));
      const Vec3 p = ray.origin - ray.origin.z() / ray.direction.z() * ray.direction;
      map.at<cv::Vec2f>(y, x) = {static_cast<float>((p.x() + kSquare_mm) * kPixelsPerMm - 0.5),
                                 static_cast<float>((p.y() + kSquare_mm) * kPixelsPerMm - 0.5)};
    }
  cv::Mat blurred, large, image;
  cv::GaussianBlur(print, blurred, {0, 0}, 2.0);
  cv::remap(blurred, large, map, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT,
            cv::Scalar(90));
  cv::resize(large, image, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  cv::Mat noise(image.size(), CV_8U);
  cv::RNG random(view);
  random.fill(noise, cv::RNG::NORMAL, 10, 2);
  return image + noise - cv::Scalar(10);
}

std::vector<std::string> Photographs(const Scratch& folder, BoardKind kind, int count) {
  const cv::Mat print = Print(kind);
  std::vector<std::string> files;
  for (int view = 0; view < count; ++view) {
    files.push_back(folder / ("b" + std::to_string(view) + ".png"));
    cv::imwrite(files.back(), Photograph(print, view));
  }
  return files;
}

class Calibration : public ::testing::TestWithParam<BoardKind> {};

TEST_P(Calibration, RecoversTheLens) {
  Scratch folder("calibration");
  Progress silent;
  const auto files = Photographs(folder, GetParam(), 9);
  const CalibrationResult result = CalibrateCamera(files, Board(GetParam()), silent);
  const CameraModel truth = Lens();
  EXPECT_NEAR(result.camera.fx, truth.fx, 3);
  EXPECT_NEAR(result.camera.fy, truth.fy, 3);
  EXPECT_NEAR(result.camera.cx, truth.cx, 3);
  EXPECT_NEAR(result.camera.cy, truth.cy, 3);
  EXPECT_LT(result.rms_px, 0.3);
  EXPECT_EQ(result.camera.width, 640);
  // The lens as a whole: where rays go, over the part of the image that the board covered.
  for (double u = 80; u < 600; u += 80)
    for (double v = 60; v < 440; v += 60) {
      const Vec2 ray = truth.Undistort(Vec2(u, v));
      EXPECT_LT((result.camera.Distort(ray) - Vec2(u, v)).norm(), 1.5) << u << "," << v;
    }
  int used = 0;
  for (const CalibrationView& view : result.views) used += view.problem.empty() ? 1 : 0;
  EXPECT_GE(used, 6);
}
INSTANTIATE_TEST_SUITE_P(Boards, Calibration,
                         ::testing::Values(BoardKind::Chessboard, BoardKind::Charuco));

TEST(CalibrationInput, BadPicturesAreNamedAndLeftOut) {
  Scratch folder("calibration-bad");
  Progress silent;
  auto files = Photographs(folder, BoardKind::Charuco, 7);
  cv::imwrite(folder / "flat.png", cv::Mat(480, 640, CV_8U, cv::Scalar(128)));
  cv::imwrite(folder / "small.png", cv::Mat(240, 320, CV_8U, cv::Scalar(128)));
  std::ofstream(folder / "text.png") << "no image";
  // A bent print: the right half of a picture pushed down.
  cv::Mat bent = cv::imread(files[1], cv::IMREAD_GRAYSCALE);
  for (int x = 320; x < 640; ++x) {
    const int shift = static_cast<int>(0.0004 * (x - 320) * (x - 320));
    cv::Mat column = bent.col(x).clone();
    column.rowRange(0, 480 - shift).copyTo(bent.col(x).rowRange(shift, 480));
  }
  cv::imwrite(folder / "bent.png", bent);
  for (const char* name : {"flat.png", "small.png", "text.png", "bent.png"})
    files.push_back(folder / name);
  const CalibrationResult result = CalibrateCamera(files, Board(BoardKind::Charuco), silent);
  ASSERT_EQ(result.views.size(), 11U);
  for (std::size_t i = 7; i < 11; ++i) EXPECT_FALSE(result.views[i].problem.empty()) << files[i];
  EXPECT_NEAR(result.camera.fx, Lens().fx, 8);
  EXPECT_FALSE(result.warnings.empty());
}

/// Pictures that no camera could have taken: the print under unrelated projective maps.
TEST(CalibrationInput, PicturesThatFitNoLensAreRefused) {
  Scratch folder("calibration-nonsense");
  Progress silent;
  const cv::Mat print = Print(BoardKind::Chessboard);
  const float w = static_cast<float>(print.cols), h = static_cast<float>(print.rows);
  const std::vector<cv::Point2f> corners{{0, 0}, {w, 0}, {w, h}, {0, h}};
  const std::vector<std::vector<cv::Point2f>> places{{{60, 40}, {600, 10}, {620, 440}, {20, 470}},
                                                     {{10, 60}, {560, 30}, {630, 420}, {70, 440}},
                                                     {{80, 20}, {540, 70}, {600, 470}, {20, 400}},
                                                     {{30, 30}, {630, 90}, {570, 400}, {90, 460}}};
  std::vector<std::string> files;
  for (const auto& place : places) {
    cv::Mat image;
    cv::warpPerspective(print, image, cv::getPerspectiveTransform(corners, place), {640, 480},
                        cv::INTER_AREA, cv::BORDER_CONSTANT, cv::Scalar(90));
    files.push_back(folder / ("n" + std::to_string(files.size()) + ".png"));
    cv::imwrite(files.back(), image);
  }
  EXPECT_THROW(CalibrateCamera(files, Board(BoardKind::Chessboard), silent), InputError);
}

TEST(CalibrationInput, TooFewOrWrong) {
  Scratch folder("calibration-few");
  Progress silent;
  const auto files = Photographs(folder, BoardKind::Chessboard, 2);
  EXPECT_THROW(CalibrateCamera(files, Board(BoardKind::Chessboard), silent), InputError);
  EXPECT_THROW(CalibrateCamera({folder / "none.png"}, Board(BoardKind::Chessboard), silent),
               InputError);
  EXPECT_THROW(CalibrateCamera({}, Board(BoardKind::Chessboard), silent), UsageError);
  CalibrationBoard board = Board(BoardKind::Charuco);
  board.marker_mm = 11;
  EXPECT_THROW(board.Validate(), UsageError);
  board = Board(BoardKind::Charuco);
  board.dictionary = "9x9";
  EXPECT_THROW(board.Validate(), UsageError);
  board = Board(BoardKind::Chessboard);
  board.columns = 2;
  EXPECT_THROW(board.Validate(), UsageError);
  board = Board(BoardKind::Chessboard);
  board.square_mm = 0;
  EXPECT_THROW(board.Validate(), UsageError);
}

}  // namespace
