#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "CaseIO/ResultsFiles.h"
#include "Core/Camera.h"
#include "Geometry/SurfaceTree.h"
#include "Pipelines/Report.h"
#include "Session/ModelView.h"
#include "Session/RegistrationSession.h"

namespace kerf {

/// Writes a results folder (DESIGN §3) while a registration runs. LPS, mm.
class ResultsWriter {
 public:
  /// @param folder made where it does not exist; files of an earlier run that would contradict are
  /// removed
  /// @param uncut the organ's rest surface before any cut
  /// @throws InputError when the folder cannot be written
  /// @param features write features.csv too (some 20 kB a frame)
  ResultsWriter(const std::string& folder, const CameraModel& camera, SurfaceMesh uncut,
                bool features = true);

  Journal& GetJournal() { return journal_; }
  using OrganView = kerf::OrganView;
  /// Valid until the next call.
  const OrganView& View(const RegistrationState& state) { return view_.Update(state); }

  /// One frame: rows of the tables; journal entries for cuts and gate changes.
  void AddFrame(const SessionFrame& frame, const RegistrationState& state, double capture_ms,
                double render_ms);
  /// Meshes of one frame (frames of eval_frames).
  void WriteMeshes(const SessionFrame& frame, const RegistrationState& state);
  /// cuts.json as of this state.
  void WriteCuts(const RegistrationState& state);
  /// The tables and the final meshes.
  void Finish(const RegistrationState& state);

  const std::vector<TimingRow>& Timing() const { return timing_; }
  const std::vector<ReliabilityRow>& ReliabilityRows() const { return reliability_; }
  const std::vector<ReportFit>& Fit() const { return fit_; }
  /// After Finish: what cuts.json holds.
  const std::vector<CutRecord>& Cuts() const { return cuts_; }

 private:
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  std::string folder_;
  CameraModel camera_;
  SurfaceTree uncut_;
  ModelView view_;
  Journal journal_;
  std::optional<FeaturesFile> features_;
  std::vector<ReliabilityRow> reliability_;
  std::vector<TimingRow> timing_;
  std::vector<ReportFit> fit_;
  std::vector<CutRecord> cuts_;
  std::string gate_;
};

}  // namespace kerf
