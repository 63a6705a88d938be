#include "Adapters/Rendering/VirtualDisplay.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "Adapters/Rendering/DisplayProbe.h"

namespace kerf {
namespace {

std::atomic<pid_t> server_pid{-1};
std::atomic<int> display_number{-1};
std::thread keeper;

// MIT-MAGIC-COOKIE-1 for any address, in the format of an X authority file. Without it every local
// user could look at what is drawn, which is a patient's video.
std::string AuthorityRecord() {
  std::string cookie(16, '\0');
  std::ifstream("/dev/urandom", std::ios::binary).read(cookie.data(), 16);
  std::string record;
  const auto put16 = [&record](int n) {
    record += static_cast<char>(n >> 8);
    record += static_cast<char>(n & 255);
  };
  const auto put = [&](const std::string& s) {
    put16(static_cast<int>(s.size()));
    record += s;
  };
  put16(0xFFFF);  // FamilyWild
  put("");
  put("");
  put("MIT-MAGIC-COOKIE-1");
  put(cookie);
  return record;
}

// In the child: only async-signal-safe calls between fork and exec.
[[noreturn]] void BecomeServer(pid_t parent, int displayfd, int authfd, char* const argv[]) {
  setsid();  // Ctrl-C in the shell is for us, not for the server: we cancel in order and end it
             // afterwards
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (int s : {SIGINT, SIGTERM, SIGPIPE, SIGHUP, SIGUSR1}) signal(s, SIG_DFL);
  const int null = open("/dev/null", O_RDWR);
  for (int fd = 0; fd < 3; ++fd) dup2(null, fd);
  dup2(displayfd, 3);
  dup2(authfd, 4);
  for (int fd = 5; fd < 1024; ++fd) close(fd);
  execvp("Xvfb", argv);
  _exit(127);
}

int ReadDisplayNumber(int fd) {
  std::string text;
  pollfd wait{fd, POLLIN, 0};
  while (text.find('\n') == std::string::npos) {
    if (poll(&wait, 1, 15000) <= 0) return -1;
    std::array<char, 32> buffer;
    const ssize_t n = read(fd, buffer.data(), buffer.size());
    if (n <= 0) return -1;
    text.append(buffer.data(), static_cast<size_t>(n));
  }
  try {
    return std::stoi(text);
  } catch (const std::exception&) {
    return -1;
  }
}

// High numbers, so that the fixed 3 and 4 of the child never meet them.
int Raise(int fd) {
  const int high = fcntl(fd, F_DUPFD_CLOEXEC, 64);
  close(fd);
  return high;
}

bool StartServer(std::string* why) {
  int pipe_fd[2];
  if (pipe2(pipe_fd, O_CLOEXEC) != 0) {
    *why = "no pipe for the virtual display";
    return false;
  }
  const int read_fd = Raise(pipe_fd[0]), write_fd = Raise(pipe_fd[1]);
  // Lives in memory alone: nothing to clean up after a crash. Xlib and the server open it through
  // /proc.
  const int authority = Raise(memfd_create("kerf-xauthority", MFD_CLOEXEC));
  const std::string record = AuthorityRecord();
  if (authority < 0 || write(authority, record.data(), record.size()) != ssize_t(record.size())) {
    *why = "no memory for the virtual display's cookie";
    return false;
  }
  static char arguments[][32] = {"Xvfb",  "-displayfd",      "3",         "-screen",
                                 "0",     "1920x1080x24",    "-nolisten", "tcp",
                                 "-auth", "/proc/self/fd/4", "-noreset"};
  std::vector<char*> argv;
  for (auto& a : arguments) argv.push_back(a);
  argv.push_back(nullptr);

  // PR_SET_PDEATHSIG fires when the forking THREAD ends: a thread that lives as long as the process
  // forks, then waits.
  std::atomic<bool> forked{false};
  keeper = std::thread([&forked, write_fd, authority, argv] {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
    const pid_t parent = getpid(), pid = fork();
    if (pid == 0) BecomeServer(parent, write_fd, authority, argv.data());
    close(write_fd);
    server_pid = pid;
    forked = true;
    if (pid > 0)
      while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
      }
    server_pid = -1;
    display_number = -1;
  });
  while (!forked) std::this_thread::yield();
  const int number = ReadDisplayNumber(read_fd);
  close(read_fd);
  if (number < 0) {
    EndVirtualDisplay();
    close(authority);
    *why = "Xvfb could not be started (package xvfb)";
    return false;
  }
  display_number = number;
  setenv("DISPLAY", (":" + std::to_string(number)).c_str(), 1);
  setenv("XAUTHORITY", ("/proc/self/fd/" + std::to_string(authority)).c_str(), 1);
  return true;
}

}  // namespace

void EndVirtualDisplay() {
  const pid_t pid = server_pid;
  if (pid > 0) kill(pid, SIGTERM);
  if (keeper.joinable()) keeper.join();
}

int VirtualDisplayNumber() { return display_number; }

bool RenderingAvailable(std::string* why_not) {
  static std::mutex mutex;
  static bool decided = false, available = false;
  static std::string reason;
  const std::lock_guard<std::mutex> lock(mutex);
  if (!decided) {
    decided = true;
    std::string given_problem;
    const char* given = std::getenv("DISPLAY");
    if (given && *given) available = ProbeDisplay(&given_problem);
    if (!available) {
      std::atexit(EndVirtualDisplay);
      available = StartServer(&reason) && ProbeDisplay(&reason);
      if (!available) {
        EndVirtualDisplay();
        reason = "no display to draw on: " + reason;
        if (!given_problem.empty())
          reason += " (DISPLAY=" + std::string(given) + ": " + given_problem + ")";
      }
    }
  }
  if (why_not) *why_not = available ? "" : reason;
  return available;
}

}  // namespace kerf
