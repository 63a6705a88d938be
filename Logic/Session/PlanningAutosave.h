#pragma once

#include <optional>
#include <string>

#include "Session/PlanningSession.h"

namespace kerf {

/// Unsaved work as a crash leaves it. The CT itself is not in it: its path is.
struct PlanningWork {
  std::string ct_path, series;
  LabelMap labels;  ///< names and grid of the CT
  PlanningSession::Restored rest;
};

/// A copy of the session's work, quick (voxels are shared), for SaveWork on another thread.
PlanningWork TakeWork(const PlanningSession& session);

/// Writes the work into one file, atomically. Labels are kept as runs. @throws InputError
void SaveWork(const PlanningWork& work, const std::string& file);
/// @throws InputError naming file and element
PlanningWork LoadWork(const std::string& file);
/// The path of the CT alone, for a question about the work; empty where the file cannot be read.
std::string CtOfWork(const std::string& file);

}  // namespace kerf
