#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "Registration/CutView.h"
#include "Session/IntraoperativeSnapshot.h"
#include "Session/ModelView.h"

namespace kerf {

/// The planned resection, at rest, LPS, mm.
struct PlannedCut {
  std::vector<Points> lines;  ///< on the organ's surface
  SurfaceMesh sheet;          ///< empty: lines only
  double margin_mm =
      std::numeric_limits<double>::quiet_NaN();  ///< wanted between tumour and cut, NaN: no plan
};

/// Makes snapshots of a registration: all that follows from its state, the same live and in a
/// replay. Gate and reason are the registration's own; what concerns source and recording is left
/// to the caller.
class SnapshotMaker {
 public:
  /// @param uncut rest surface before any cut
  SnapshotMaker(const SurfaceMesh& uncut, PlannedCut plan);

  /// @param report of the last frame; cuts that are new are dated by it
  std::shared_ptr<IntraoperativeSnapshot> Make(const Frame& frame, const SessionFrame& report,
                                               const RegistrationState& state);

 private:
  void Lines(const RegistrationState& state, IntraoperativeSnapshot* out);
  /// The last snapshot without a cut in its model; rather one whose gate was not off.
  std::shared_ptr<const IntraoperativeSnapshot> LastWithout(std::size_t cut) const;
  /// Older where `before` still shows a cut that is no longer in the model.
  std::shared_ptr<const IntraoperativeSnapshot> Valid(
      std::shared_ptr<const IntraoperativeSnapshot> before, const RegistrationState& state) const;
  void Cuts(const SessionFrame& report, const RegistrationState& state,
            IntraoperativeSnapshot* out);

  SurfaceTree uncut_;
  PlannedCut plan_;
  std::optional<SurfaceTree> sheet_;
  ModelView view_;
  CutView cut_view_;
  struct BoundLines {  ///< planned and proposed lines in the mesh; remade when either changes
    std::string of;
    std::vector<Embedding> planned, proposed;
    PlanDeviation deviation;
  } bound_;
  struct Known {  ///< what is remembered of a cut
    double time_s = 0.0;
    bool in_model = false;
    std::shared_ptr<const IntraoperativeSnapshot> before;
  };
  std::vector<Known> known_;
  std::shared_ptr<const IntraoperativeSnapshot> trusted_,  ///< the last whose gate was not off
      previous_;
};

}  // namespace kerf
