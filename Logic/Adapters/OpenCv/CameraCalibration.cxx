#include "Adapters/OpenCv/CameraCalibration.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/ImageSequence.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// A view that fits this much worse than the usual one (and by more than half a pixel) shows a bent
/// or misread board.
constexpr double kBadViewRatio = 3.0, kBadViewLeast_px = 0.5;
constexpr int kLeastViews = 3, kLeastCorners = 6;
/// Beyond these the pictures do not show one flat board through one lens, and no camera file is
/// better than a wrong one.
constexpr double kWorstRms_px = 2.0, kWorstAspect = 0.15;

std::optional<int> DictionaryOf(const std::string& name) {
  static const std::pair<const char*, int> kKnown[] = {
      {"4x4_50", cv::aruco::DICT_4X4_50},   {"4x4_100", cv::aruco::DICT_4X4_100},
      {"4x4_250", cv::aruco::DICT_4X4_250}, {"5x5_50", cv::aruco::DICT_5X5_50},
      {"5x5_100", cv::aruco::DICT_5X5_100}, {"5x5_250", cv::aruco::DICT_5X5_250},
      {"6x6_50", cv::aruco::DICT_6X6_50},   {"6x6_100", cv::aruco::DICT_6X6_100},
      {"6x6_250", cv::aruco::DICT_6X6_250}, {"original", cv::aruco::DICT_ARUCO_ORIGINAL}};
  for (const auto& [known, value] : kKnown)
    if (name == known) return value;
  return std::nullopt;
}

struct Corners {
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point3f> places_mm;  ///< on the board, z = 0
};

/// Finds the board's corners in one picture.
class BoardFinder {
 public:
  explicit BoardFinder(const CalibrationBoard& board) : board_(board) {
    if (board.kind != BoardKind::Charuco) return;
    dictionary_ = cv::aruco::getPredefinedDictionary(*DictionaryOf(board.dictionary));
    charuco_ = cv::aruco::CharucoBoard::create(board.columns, board.rows,
                                               static_cast<float>(board.square_mm),
                                               static_cast<float>(board.marker_mm), dictionary_);
  }
  Corners Find(const cv::Mat& grey) const {
    return board_.kind == BoardKind::Charuco ? FindCharuco(grey) : FindChessboard(grey);
  }

 private:
  Corners FindChessboard(const cv::Mat& grey) const {
    Corners corners;
    const cv::Size size(board_.columns - 1, board_.rows - 1);
    if (!cv::findChessboardCornersSB(grey, size, corners.pixels,
                                     cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY))
      return {};
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        corners.places_mm.emplace_back(static_cast<float>(x * board_.square_mm),
                                       static_cast<float>(y * board_.square_mm), 0.0F);
    return corners;
  }
  Corners FindCharuco(const cv::Mat& grey) const {
    std::vector<std::vector<cv::Point2f>> markers, rejected;
    std::vector<int> marker_ids, corner_ids;
    const cv::Ptr<cv::aruco::DetectorParameters> parameters =
        cv::aruco::DetectorParameters::create();
    cv::aruco::detectMarkers(grey, dictionary_, markers, marker_ids, parameters, rejected);
    if (marker_ids.empty()) return {};
    cv::aruco::refineDetectedMarkers(grey, charuco_, markers, marker_ids, rejected);
    Corners corners;
    cv::aruco::interpolateCornersCharuco(markers, marker_ids, grey, charuco_, corners.pixels,
                                         corner_ids);
    for (const int id : corner_ids) corners.places_mm.push_back(charuco_->chessboardCorners[id]);
    return corners;
  }

  CalibrationBoard board_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::CharucoBoard> charuco_;
};

struct Fit {
  cv::Mat matrix, distortion, deviations;
  std::vector<double> view_rms_px;
  double rms_px = 0.0;
};

Fit Solve(const std::vector<Corners>& views, cv::Size size, bool with_k3) {
  std::vector<std::vector<cv::Point3f>> places;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const Corners& view : views) {
    places.push_back(view.places_mm);
    pixels.push_back(view.pixels);
  }
  Fit fit;
  cv::Mat view_errors, ignored;
  std::vector<cv::Mat> rotations, translations;
  fit.rms_px =
      cv::calibrateCamera(places, pixels, size, fit.matrix, fit.distortion, rotations, translations,
                          fit.deviations, ignored, view_errors, with_k3 ? 0 : cv::CALIB_FIX_K3,
                          {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-10});
  for (int i = 0; i < view_errors.rows; ++i) fit.view_rms_px.push_back(view_errors.at<double>(i));
  return fit;
}

/// k3 is kept only when the pictures show it: free parameters bend the corners of the image.
Fit SolveBest(const std::vector<Corners>& views, cv::Size size) {
  Fit plain = Solve(views, size, false);
  if (views.size() < 8) return plain;
  Fit full = Solve(views, size, true);
  constexpr int kK3 = 8;  // fx fy cx cy k1 k2 p1 p2 k3
  const bool shown =
      std::abs(full.distortion.at<double>(4)) > 4 * full.deviations.at<double>(kK3) &&
      full.rms_px < 0.97 * plain.rms_px;
  return shown ? full : plain;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Share of a 6 × 4 grid of the image in which there is a corner.
double Coverage(const std::vector<Corners>& views, cv::Size size) {
  bool seen[4][6] = {};
  for (const Corners& view : views)
    for (const cv::Point2f& p : view.pixels)
      seen[std::clamp(static_cast<int>(p.y * 4 / size.height), 0, 3)]
          [std::clamp(static_cast<int>(p.x * 6 / size.width), 0, 5)] = true;
  int cells = 0;
  for (const auto& row : seen)
    for (const bool cell : row) cells += cell ? 1 : 0;
  return cells / 24.0;
}

CameraModel ToCamera(const Fit& fit, cv::Size size) {
  CameraModel camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx = fit.matrix.at<double>(0, 0);
  camera.fy = fit.matrix.at<double>(1, 1);
  camera.cx = fit.matrix.at<double>(0, 2);
  camera.cy = fit.matrix.at<double>(1, 2);
  for (int i = 0; i < 5; ++i) camera.distortion[i] = fit.distortion.at<double>(i);
  return camera;
}

}  // namespace

void CalibrationBoard::Validate() const {
  if (columns < 3 || rows < 3)
    throw UsageError("a board has at least 3 columns and 3 rows of squares");
  if (!(square_mm > 0)) throw UsageError("the side of a square has to be a positive number of mm");
  if (kind == BoardKind::Chessboard) {
    if (columns < 4 || rows < 4) throw UsageError("a chessboard has at least 4 columns and 4 rows");
    return;
  }
  if (!(marker_mm > 0 && marker_mm < square_mm))
    throw UsageError("the side of a marker has to be smaller than that of a square");
  const std::optional<int> dictionary_number = DictionaryOf(dictionary);
  if (!dictionary_number) throw UsageError("unknown marker dictionary '" + dictionary + "'");
  const int markers = cv::aruco::getPredefinedDictionary(*dictionary_number)->bytesList.rows;
  if (columns * rows / 2 > markers)
    throw UsageError("the dictionary " + dictionary + " has too few markers for this board");
}

CalibrationResult CalibrateCamera(const std::vector<std::string>& files,
                                  const CalibrationBoard& board, Progress& progress) {
  board.Validate();
  if (files.empty()) throw UsageError("no image of the board was given");
  const BoardFinder finder(board);
  CalibrationResult result;
  std::vector<Corners> found;
  std::vector<std::size_t> view_of;
  cv::Size size;
  for (std::size_t i = 0; i < files.size(); ++i) {
    progress.ThrowIfCancelled();
    progress.Report(0.8 * static_cast<double>(i) / static_cast<double>(files.size()),
                    "finding the board");
    CalibrationView view;
    view.file = files[i];
    const std::optional<Image> image = ReadImageFile(files[i]);
    if (!image) {
      view.problem = "cannot be read as an image";
    } else if (!size.empty() && size != cv::Size(image->width, image->height)) {
      view.problem = "its size differs from that of the images before it";
    } else {
      size = cv::Size(image->width, image->height);
      cv::Mat grey;
      cv::cvtColor(ViewOf(*image), grey, cv::COLOR_BGR2GRAY);
      Corners corners = finder.Find(grey);
      view.corners = static_cast<int>(corners.pixels.size());
      if (view.corners < kLeastCorners) {
        view.problem = view.corners == 0 ? "the board was not found" : "too few corners were found";
      } else {
        found.push_back(std::move(corners));
        view_of.push_back(i);
      }
    }
    result.views.push_back(std::move(view));
  }
  const auto demand_views = [&] {
    if (static_cast<int>(found.size()) >= kLeastViews) return;
    for (const CalibrationView& view : result.views)
      if (!view.problem.empty())
        throw InputError(view.file, "",
                         view.problem + "; of " + std::to_string(files.size()) + " images " +
                             std::to_string(found.size()) + " can be used, at least " +
                             std::to_string(kLeastViews) + " are needed");
    throw InputError(files[0], "",
                     "at least " + std::to_string(kLeastViews) + " images are needed");
  };
  demand_views();
  progress.Report(0.85, "estimating the lens");
  Fit fit = SolveBest(found, size);
  // Once: a bad view spoils the others' errors too, so a second look would throw out good ones.
  const double limit_px = std::max(kBadViewLeast_px, kBadViewRatio * Median(fit.view_rms_px));
  std::vector<Corners> kept;
  std::vector<std::size_t> kept_view_of;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (fit.view_rms_px[k] > limit_px) {
      result.views[view_of[k]].problem = "fits far worse than the others: bent, blurred or misread";
    } else {
      kept.push_back(found[k]);
      kept_view_of.push_back(view_of[k]);
    }
  }
  if (kept.size() < found.size()) {
    found = std::move(kept);
    view_of = std::move(kept_view_of);
    demand_views();
    fit = SolveBest(found, size);
  }
  for (std::size_t k = 0; k < found.size(); ++k)
    result.views[view_of[k]].rms_px = fit.view_rms_px[k];
  result.camera = ToCamera(fit, size);
  result.rms_px = fit.rms_px;
  result.focal_deviation_px = fit.deviations.at<double>(0);
  if (result.rms_px > kWorstRms_px ||
      std::abs(result.camera.fx / result.camera.fy - 1) > kWorstAspect)
    throw InputError(files[0], "",
                     "this and the other pictures do not fit one lens and one flat board: wrong "
                     "board, scaled or cropped pictures, or zoom changed in between");
  result.camera.Validate(files[0]);
  if (found.size() < 8)
    result.warnings.push_back("only " + std::to_string(found.size()) +
                              " images were used; 10 to 20 from different angles are better");
  if (Coverage(found, size) < 0.7)
    result.warnings.push_back(
        "the board leaves parts of the image uncovered: the distortion is a guess there");
  if (result.rms_px > 1.0)
    result.warnings.push_back(
        "the reprojection error is above 1 px: check the square size, blur and focus");
  if (result.focal_deviation_px > 0.02 * result.camera.fx)
    result.warnings.push_back("the focal length is uncertain: tilt the board more");
  progress.Report(1.0, "estimating the lens");
  return result;
}

}  // namespace kerf
