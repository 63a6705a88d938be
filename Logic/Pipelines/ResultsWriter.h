#pragma once

#include <memory>
#include <string>
#include <vector>

#include "CaseIO/ResultsFiles.h"
#include "Core/Camera.h"
#include "Geometry/SurfaceTree.h"
#include "Pipelines/Report.h"
#include "Session/RegistrationSession.h"

namespace kerf {

/// Writes a results folder (DESIGN §3) while a registration runs. LPS, mm.
class ResultsWriter {
 public:
  /// @param folder made where it does not exist; files of an earlier run that would contradict are
  /// removed
  /// @param uncut the organ's rest surface before any cut
  /// @throws InputError when the folder cannot be written
  ResultsWriter(const std::string& folder, const CameraModel& camera, SurfaceMesh uncut);

  Journal& GetJournal() { return journal_; }
  /// The organ's boundary as it is in this state, with its rest positions and the faces of cuts.
  /// Valid until the next call.
  struct OrganView {
    SurfaceMesh current;
    Points rest;
    std::vector<std::uint8_t> cut_face;  ///< per triangle
  };
  const OrganView& View(const RegistrationState& state);
  /// The cut lines on the rest surface, one per cut.
  Points SurfaceLine(const ModelCut& cut) const;

  /// One frame: rows of the tables; journal entries for cuts and gate changes.
  void AddFrame(const SessionFrame& frame, const RegistrationState& state, double capture_ms,
                double render_ms);
  /// Meshes of one frame (frames of eval_frames).
  void WriteMeshes(const SessionFrame& frame, const RegistrationState& state);
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
  Journal journal_;
  FeaturesFile features_;
  std::vector<ReliabilityRow> reliability_;
  std::vector<TimingRow> timing_;
  std::vector<ReportFit> fit_;
  std::vector<CutRecord> cuts_;
  OrganView view_;
  std::vector<Index> vertex_of_point_;
  Index view_tets_ = -1, view_vertices_ = -1;
  std::string gate_;
};

}  // namespace kerf
