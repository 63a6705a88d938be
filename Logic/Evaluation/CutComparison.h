#pragma once

#include <optional>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// A cut as it really was: start, and its line on the rest surface (LPS, mm).
struct TrueCut {
  double start_frame = 0.0, start_time_s = 0.0;
  std::optional<double> first_frame_opening_over_1mm;
  Points polyline_rest;
};

/// A cut as a program reports it.
struct DetectedCut {
  std::optional<double> detected_frame;
  Points polyline_rest;  ///< LPS, mm
};

/// Distances between two lines that were densified to 0.5 mm, mm.
struct LineDistance {
  double mean_mm = 0.0, hausdorff_mm = 0.0;  ///< over both sides
  double detected_to_true_max_mm = 0.0, true_to_detected_max_mm = 0.0;
  double detected_to_true_median_mm = 0.0;
};
/// Neither line may be empty.
LineDistance CompareLines(const Points& detected, const Points& truth);

struct CutMatch {
  int detected = -1, truth = -1;
  LineDistance location;
  double true_start_s = 0.0;
  std::optional<double> timing_error_s;  ///< detected − true start
  std::optional<double>
      delay_after_1mm_opening_s;  ///< the fairer reference: opening first over 1 mm
};

struct CutComparison {
  int truth = 0, detected = 0, missed = 0, false_cuts = 0;
  std::vector<CutMatch> matched;
};

/// Pairs cuts one to one, nearest lines first. A pair is refused when the median distance is over
/// 15 mm or when the cut was reported more than 0.2 s before it began.
CutComparison CompareCuts(const std::vector<DetectedCut>& detected,
                          const std::vector<TrueCut>& truth, double frames_per_second);

}  // namespace kerf
