#include "CommandContext.h"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <iostream>

namespace kerf {
namespace {

std::atomic<bool> cancelled{false};

extern "C" void OnSignal(int) {
  // A second signal ends the process at once.
  if (cancelled.exchange(true)) _exit(130);
}

/// One JSON object a line. @throws InputError when the file cannot be written
void OpenLog(const std::string& path) {
  try {
    auto logger = spdlog::basic_logger_mt("kerf", path);
    logger->set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%e","level":"%l","message":%v})");
    logger->flush_on(spdlog::level::info);
    spdlog::set_default_logger(logger);
  } catch (const spdlog::spdlog_ex& error) {
    throw InputError(path, "", error.what());
  }
}

class ShellProgress : public Progress {
 public:
  explicit ShellProgress(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO)) {}
  ~ShellProgress() override { ClearLine(); }
  void Report(double fraction, const std::string& what) override {
    if (what != last_what_) spdlog::info("{}", nlohmann::json(what).dump());
    last_what_ = what;
    if (quiet_ || !terminal_) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(100) && fraction < 1.0) return;
    last_ = now;
    std::fprintf(stderr, "\r\033[K%3d %%  %s", static_cast<int>(100.0 * fraction), what.c_str());
    std::fflush(stderr);
    line_ = true;
  }
  void Warn(const std::string& message) override {
    spdlog::warn("{}", nlohmann::json(message).dump());
    if (quiet_) return;
    ClearLine();
    std::cerr << "kerf: warning: " << message << std::endl;
  }
  bool IsCancelled() const override { return cancelled; }

 private:
  void ClearLine() {
    if (line_) std::fputs("\r\033[K", stderr);
    line_ = false;
  }
  bool quiet_, terminal_, line_ = false;
  std::chrono::steady_clock::time_point last_{};
  std::string last_what_;
};

}  // namespace

void CommandContext::Print(const std::string& text) const {
  if (!json && !quiet) std::cout << text << std::endl;
}

std::unique_ptr<Progress> MakeShellProgress(bool quiet) {
  return std::make_unique<ShellProgress>(quiet);
}

void InstallCancelHandler() {
  // Nothing is logged until --log names a file; spdlog would write to stdout.
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "kerf-none", std::make_shared<spdlog::sinks::null_sink_mt>()));
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
}

void AddCommonOptions(CLI::App* command, CommandContext* context) {
  command->add_flag("--json", context->json, "print machine-readable results on stdout");
  command->add_flag("--quiet", context->quiet, "no progress and no warnings");
  command->add_option_function<std::string>(
      "--log",
      [](const std::string& path) {
        OpenLog(path);
        spdlog::info("{}", nlohmann::json("kerf " KERF_VERSION).dump());
      },
      "write a structured log (one JSON object a line) to this file");
}

}  // namespace kerf
