#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "Core/Progress.h"

namespace kerf {

/// What every command shares: the options that stand on all of them, the progress line, the
/// machine-readable result.
struct CommandContext {
  bool json = false;   ///< `--json`: `result` is printed on stdout at the end
  bool quiet = false;  ///< no progress, no warnings
  int threads = 0;     ///< `--threads`; 0 = all cores
  nlohmann::json result = nlohmann::json::object();
  std::unique_ptr<Progress> progress;  ///< never null while a command runs
  int exit_status = 0;                 ///< a command sets 4 for "done, but below what was required"

  /// Text for people: stdout, or nowhere when `--json` or `--quiet`.
  void Print(const std::string& text) const;
};

/// Progress on stderr when it is a terminal, warnings always (unless quiet); cancelled by
/// SIGINT/SIGTERM.
std::unique_ptr<Progress> MakeShellProgress(bool quiet);
void InstallCancelHandler();

/// Adds --json, --quiet, --log, --threads to a command.
void AddCommonOptions(CLI::App* command, CommandContext* context);

}  // namespace kerf
