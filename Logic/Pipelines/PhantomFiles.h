#pragma once
// Private to Pipelines: the files of a phantom study in the studies' own frame (RAS).

#include <string>

#include "Phantom/PhantomTracks.h"

namespace kerf {

/// camera.yml with T_cam_from_ct (RAS). @param comment one line
void WriteStudyCamera(const std::string& path, const CameraModel& camera,
                      const std::string& comment);

/// The description of the study for people and programs.
/// @param grid of the CT, null for bands; @param labels null for bands
void WriteStudyManifest(const std::string& path, const PhantomSetup& setup,
                        const PhantomAnatomy& anatomy, const LabelMap* labels);

/// truth/cuts.json: start, growth, line, lips.
void WriteTrueCuts(const std::string& path, const PhantomSetup& setup, const PhantomMotion& motion);

/// dims.json of a band.
void WriteBandDimensions(const std::string& path, const PhantomSetup& setup);

}  // namespace kerf
