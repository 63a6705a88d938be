#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "Core/Volume.h"

namespace kerf {

/// A row of the label list.
struct LabelInfo {
  int value = 1;
  std::string name;                      ///< of the segment: organ, tumour, internal
  std::string title;                     ///< for people: "Vessels, calyces"
  std::array<std::uint8_t, 3> color{0};  ///< red, green, blue
  bool visible = true;
};
/// Organ, tumour, inner structures: what a case holds.
std::vector<LabelInfo> StandardLabels();

/// What an edit changed: runs of voxels that had one value and got another.
struct LabelDelta {
  struct Run {
    std::size_t offset = 0;
    std::uint32_t length = 0;
    std::uint8_t before = 0, after = 0;
  };
  std::vector<Run> runs;
  bool Empty() const { return runs.empty(); }
  std::size_t Bytes() const { return runs.size() * sizeof(Run); }
};
/// Both arrays have the same size.
LabelDelta Difference(const std::vector<std::uint8_t>& before,
                      const std::vector<std::uint8_t>& after);

/// What a tool made of a map, and in what it differs. Made where the tool runs, since comparing
/// takes a tenth of a second on a large CT; an editor takes it over at once.
struct LabelEdit {
  std::shared_ptr<const std::vector<std::uint8_t>> before;
  std::shared_ptr<std::vector<std::uint8_t>> after;
  LabelDelta delta;
};
/// @throws std::invalid_argument when the voxel counts differ
LabelEdit CompareLabels(const LabelMap& before, std::vector<std::uint8_t> after);

/// A map whose voxels are counted, for the same reason.
struct CountedLabels {
  LabelMap labels;
  std::array<std::size_t, 256> counts{};
};
/// @throws std::invalid_argument when the voxel count is not the grid's
CountedLabels CountLabels(LabelMap labels);
/// Everything background.
CountedLabels NoLabels(const GridGeometry& grid, const std::string& source);

/// The label map that is being edited, on the CT's grid. Voxels that somebody else holds (a running
/// job, an autosave) are copied before they are changed: what was handed out never changes.
class LabelEditor {
 public:
  /// Everything background.
  void Reset(const GridGeometry& grid, const std::string& source);
  void Reset(const CountedLabels& counted);

  const LabelMap& Labels() const { return labels_; }
  /// A map that stays as it is now.
  LabelMap Snapshot() const { return labels_; }
  std::uint64_t Revision() const { return revision_; }
  std::size_t Count(int label) const { return counts_[label]; }
  double Volume_ml(int label) const;
  bool Empty() const { return counts_[1] + counts_[2] + counts_[3] == 0; }

  /// Applies a delta forwards (redo) or backwards (undo).
  void Apply(const LabelDelta& delta, bool forwards);
  /// The result of a tool. Where the labels were changed since, it is compared anew.
  /// @return the difference to the state before
  LabelDelta Replace(const LabelEdit& edit);

  /// A brush: a ball, or a disc in the slice across grid axis `flat_axis` (−1 = ball).
  struct Brush {
    double radius_mm = 5;
    int flat_axis = -1;
    std::uint8_t paint = 1;                ///< written; 0 erases
    int only_over = -1;                    ///< only voxels of this label are changed; −1 = all
    int low_hu = -32768, high_hu = 32767;  ///< only voxels within, where a CT is given
  };
  /// Dabs between Begin and End are one step.
  void BeginStroke();
  /// @param center voxel index (fractions allowed); @param ct may be null
  void Dab(const Brush& brush, const Vec3& center, const Volume* ct);
  LabelDelta EndStroke();

 private:
  std::vector<std::uint8_t>& Writable();

  LabelMap labels_;
  std::shared_ptr<std::vector<std::uint8_t>> voxels_;  ///< those of labels_, or null
  std::array<std::size_t, 256> counts_{};
  std::uint64_t revision_ = 0;
  std::vector<std::pair<std::size_t, std::uint8_t>> stroke_;  ///< offset, value before
};

}  // namespace kerf
