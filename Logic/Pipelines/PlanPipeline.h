#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "CaseIO/Markups.h"
#include "Core/Camera.h"
#include "Core/Progress.h"
#include "Core/Volume.h"
#include "Cutting/CutStructure.h"
#include "Geometry/EmbedPoints.h"
#include "Meshing/TetMesher.h"

namespace kerf {

/// What planning hands to the operating room. Everything at rest, patient LPS, mm.
struct PlannedCase {
  TetMesh mesh;               ///< organ with the tumour as region
  SurfaceMesh organ_surface;  ///< boundary of `mesh`
  std::vector<Structure>
      structures;  ///< "internal", "tumour", those that the labels have; embedded in `mesh`
  std::optional<LabelMap> labels;  ///< none where planned from a surface
  std::optional<Volume> ct;
  MeshingReport report;       ///< quality only, after ReadCase
  EmbeddingReport embedding;  ///< over all structures
  /// Inputs (SHA-256, no names) and parameters, for the manifest.
  std::map<std::string, std::string> provenance;
  std::optional<CameraModel> camera;   ///< calibration, and the pose where one is known
  std::string calibrated;              ///< when it was, as its file says; empty: not known
  std::vector<MarkupPoint> landmarks;  ///< for the initial registration
  std::vector<MarkupPoint> seeds;      ///< what the segmentation was told
};

/// Label map (1 organ, 2 tumour, 3 inner structure) → organ mesh, structure surfaces, embedding.
/// Deterministic.
/// @throws InputError naming labels.source: no voxel of these labels; Cancelled
PlannedCase PlanFromLabels(const LabelMap& labels, const MeshingOptions& options,
                           Progress& progress);

/// Closed surface (LPS mm) → organ mesh; there are no inner structures.
/// @throws InputError naming `file` and the element: inverted, open, self-intersecting; Cancelled
PlannedCase PlanFromSurface(const SurfaceMesh& surface, const std::string& file,
                            const MeshingOptions& options, Progress& progress);

/// Writes the case folder (DESIGN §3) in one step: after a crash there is the old one or the new
/// one.
/// @param provenance into the manifest: inputs, parameters
void WriteCase(const PlannedCase& planned, const std::string& folder,
               const std::map<std::string, std::string>& provenance = {});

/// Landmarks for a case from a study's landmarks.csv or from Slicer markups (.mrk.json).
/// @throws InputError
std::vector<MarkupPoint> ReadCaseLandmarks(const std::string& path);

/// Reads a case folder back (mesh, surface, structures and their embedding, landmarks, camera;
/// labels and CT stay on disk).
/// @throws InputError naming file and element
PlannedCase ReadCase(const std::string& folder);

/// What `kerf plan` and the Planning module ask for.
struct PlanRequest {
  std::string input;        ///< DICOM folder, NIfTI, NRRD, or closed surface
  std::string labels_file;  ///< finished label map; empty = segment the CT
  std::string seeds_file;   ///< Slicer markups
  std::string preset;       ///< "liver", "kidney" or empty
  std::string series_uid;   ///< which series of a DICOM folder; empty = the only or largest one
  MeshingOptions meshing;
  std::string camera_file;     ///< camera.yml that goes into the case; empty = none
  std::string landmarks_file;  ///< .csv of a study, or .mrk.json; empty = none
};

/// The whole job in memory: read, segment where no labels are given, mesh, embed.
/// @throws InputError, UsageError (options that contradict each other), Cancelled
PlannedCase Plan(const PlanRequest& request, Progress& progress);

}  // namespace kerf
