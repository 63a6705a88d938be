#pragma once

#include "CommandContext.h"

namespace kerf {

// One function per command, each in its own file: adds the subcommand with its options, help and
// examples; its callback does the work through Logic/Pipelines and throws InputError / UsageError /
// Cancelled.
void AddPlanCommand(CLI::App& app, CommandContext& context);
void AddReplayCommand(CLI::App& app, CommandContext& context);
void AddEvaluateCommand(CLI::App& app, CommandContext& context);
void AddExportCommand(CLI::App& app, CommandContext& context);
void AddPhantomCommand(CLI::App& app, CommandContext& context);
void AddDemoCommand(CLI::App& app, CommandContext& context);
void AddValidateCommand(CLI::App& app, CommandContext& context);
void AddCalibrateCommand(CLI::App& app, CommandContext& context);
void AddAppCommand(CLI::App& app, CommandContext& context);

}  // namespace kerf
