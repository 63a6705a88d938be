#pragma once

#include "Pipelines/ReplayPipeline.h"

namespace kerf {

/// `kerf replay CASE/sessions/<time>`: a recorded session done again (SessionRun.h) into a results
/// folder.
/// @throws InputError; also when a checksum differs, naming the frame
ReplayResult ReplaySession(const ReplayRequest& request, Progress& progress);

}  // namespace kerf
