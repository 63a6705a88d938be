// The private display ends with the process, however that ends, and its absence is survivable.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>

#include "Adapters/Rendering/GeometryBuffers.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "SceneFixtures.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

bool Draws() {
  const CameraModel lens = testing::PlainLens(64, 48);
  const SurfaceMesh ball = testing::Sphere(Vec3::Zero(), Vec3::Constant(20), 2);
  GeometryBuffers buffers(lens);
  buffers.Render({{&ball, GeometryBuffers::Outer, nullptr}}, {});
  return buffers.Front().surface[24 * 64 + 32] == GeometryBuffers::Outer;
}

// Runs in a process of its own, started by the tests below: says what it got, then ends as it is
// told.
TEST(VirtualDisplayChild, DISABLED_EndsAsTold) {
  const std::string end = std::getenv("KERF_CHILD_END"), file = std::getenv("KERF_CHILD_FILE");
  signal(SIGINT, SIG_IGN);
  std::string why;
  const bool available = RenderingAvailable(&why);
  const bool draws = available && Draws();
  {
    std::ofstream out(file + ".part");
    out << available << '\n' << VirtualDisplayNumber() << '\n' << draws << '\n' << why << '\n';
  }
  fs::rename(file + ".part", file);
  if (end == "exit") std::exit(0);
  if (end == "abort") std::abort();
  if (end == "lose-display") {
    const CameraModel lens = testing::PlainLens(64, 48);
    const SurfaceMesh ball = testing::Sphere(Vec3::Zero(), Vec3::Constant(20), 2);
    bool all = true;
    {
      GeometryBuffers buffers(lens);
      for (int i = 0; i < 6; ++i) {
        if (i == 3) EndVirtualDisplay();
        buffers.Render({{&ball, GeometryBuffers::Outer, nullptr}}, {});
        all = all && buffers.Front().surface[24 * 64 + 32] == GeometryBuffers::Outer;
      }
    }  // closes the lost connection
    std::exit(all ? 0 : 1);
  }
  if (end == "signal") std::this_thread::sleep_for(std::chrono::seconds(60));
  if (end == "draw-after-interrupt") {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    std::_Exit(Draws() ? 0 : 1);
  }
}

struct Child {
  pid_t pid = -1;
  bool available = false, draws = false;
  int display = -1;
  std::string why;
};

class VirtualDisplay : public ::testing::Test {
 protected:
  Child Start(const std::string& end, const std::map<std::string, std::string>& environment) {
    const fs::path file =
        fs::path(::testing::TempDir()) / ("kerf-child-" + std::to_string(getpid()));
    fs::remove(file);
    Child child;
    child.pid = fork();
    if (child.pid == 0) {
      setpgid(0, 0);
      unsetenv("DISPLAY");
      unsetenv("XAUTHORITY");
      for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
      setenv("KERF_CHILD_END", end.c_str(), 1);
      setenv("KERF_CHILD_FILE", file.c_str(), 1);
      execl("/proc/self/exe", "child", "--gtest_also_run_disabled_tests",
            "--gtest_filter=VirtualDisplayChild.*", static_cast<char*>(nullptr));
      _exit(127);
    }
    for (int i = 0; i < 600 && !fs::exists(file); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::ifstream in(file);
    in >> child.available >> child.display >> child.draws;
    in.ignore();
    std::getline(in, child.why);
    fs::remove(file);
    return child;
  }
  static int Wait(const Child& child) {
    int status = 0;
    waitpid(child.pid, &status, 0);
    return status;
  }
  // The server removes its lock when it ends in order.
  static bool IsGone(int display) {
    const fs::path lock = "/tmp/.X" + std::to_string(display) + "-lock";
    for (int i = 0; i < 200; ++i) {
      if (!fs::exists(lock)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  void EndsWith(const std::string& end, int signal_number) {
    const Child child = Start(end, {});
    if (!child.available) {
      Wait(child);
      GTEST_SKIP() << child.why;
    }
    EXPECT_GE(child.display, 0);
    EXPECT_TRUE(child.draws);
    if (signal_number) kill(child.pid, signal_number);
    Wait(child);
    EXPECT_TRUE(IsGone(child.display)) << "display :" << child.display << " is still there";
  }
};

TEST_F(VirtualDisplay, EndsWithAnOrderlyExit) { EndsWith("exit", 0); }
TEST_F(VirtualDisplay, EndsWithAnAbort) { EndsWith("abort", 0); }
TEST_F(VirtualDisplay, EndsWithSigterm) { EndsWith("signal", SIGTERM); }
TEST_F(VirtualDisplay, EndsWithSigkill) { EndsWith("signal", SIGKILL); }

TEST_F(VirtualDisplay, CtrlCIsForTheProgramNotForTheDisplay) {
  const Child child = Start("draw-after-interrupt", {});
  if (!child.available) {
    Wait(child);
    GTEST_SKIP() << child.why;
  }
  kill(-child.pid, SIGINT);  // as a terminal does: to the whole process group
  const int status = Wait(child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_TRUE(IsGone(child.display));
}

TEST_F(VirtualDisplay, ALostDisplayDoesNotEndTheRecording) {
  const Child child = Start("lose-display", {});
  const int status = Wait(child);
  if (!child.available) GTEST_SKIP() << child.why;
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST_F(VirtualDisplay, WithoutXvfbRenderingIsOffAndNothingBreaks) {
  const Child child = Start("exit", {{"PATH", "/nonexistent"}});
  const int status = Wait(child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_FALSE(child.available);
  EXPECT_NE(child.why.find("Xvfb"), std::string::npos) << child.why;
}

TEST_F(VirtualDisplay, ADisplayThatCannotBeOpenedIsReplaced) {
  const Child child = Start("exit", {{"DISPLAY", ":4321"}});
  Wait(child);
  if (!child.available) GTEST_SKIP() << child.why;
  EXPECT_GE(child.display, 0);
  EXPECT_NE(child.display, 4321);
  EXPECT_TRUE(child.draws);
}

TEST_F(VirtualDisplay, AGivenDisplayThatWorksIsUsed) {
  std::string why;
  if (!RenderingAvailable(&why)) GTEST_SKIP() << why;
  std::map<std::string, std::string> environment{{"DISPLAY", std::getenv("DISPLAY")}};
  if (VirtualDisplayNumber() >= 0)  // ours: its key is an open file of this process
    environment["XAUTHORITY"] = "/proc/" + std::to_string(getpid()) + "/fd/" +
                                fs::path(std::getenv("XAUTHORITY")).filename().string();
  else if (const char* key = std::getenv("XAUTHORITY"))
    environment["XAUTHORITY"] = key;
  const Child child = Start("exit", environment);
  Wait(child);
  EXPECT_TRUE(child.available);
  EXPECT_EQ(child.display, -1) << "it started another one";
  EXPECT_TRUE(child.draws);
}

TEST_F(VirtualDisplay, WithoutTheCookieTheDisplayIsClosedToOthers) {
  std::string why;
  if (!RenderingAvailable(&why)) GTEST_SKIP() << why;
  if (VirtualDisplayNumber() < 0) GTEST_SKIP() << "a display was given";
  const Child child =
      Start("exit", {{"DISPLAY", std::getenv("DISPLAY")}, {"XAUTHORITY", "/dev/null"}});
  Wait(child);
  EXPECT_NE(child.display, -1) << "it drew on ours";
}

}  // namespace
}  // namespace kerf
