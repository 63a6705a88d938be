#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "Commands.h"

namespace kerf {
namespace {

/// Becomes KerfApp, the program beside this one. The shell itself is free of Qt.
void Run(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "KerfApp").string();
  if (!fs::exists(program)) throw InputError(program, "", "the window is not installed");
  std::string case_folder = folder;
  char* const arguments[] = {const_cast<char*>("KerfApp"),
                             folder.empty() ? nullptr : case_folder.data(), nullptr};
  execv(program.c_str(), arguments);
  throw InputError(program, "", std::string("cannot be started: ") + std::strerror(errno));
}

}  // namespace

void AddAppCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c = app.add_subcommand("app", "the window: planning and the operating room");
  auto folder = std::make_shared<std::string>();
  c->add_option("CASE", *folder, "case folder to open");
  c->footer(
      "Examples:\n"
      "  kerf app\n"
      "  kerf app case\n"
      "Needs an X display. KerfApp --help lists the window's own options.");
  c->callback([folder] { Run(*folder); });
}

}  // namespace kerf
