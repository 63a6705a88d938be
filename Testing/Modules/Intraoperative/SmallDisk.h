#pragma once

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace kerf::testing {

/// A file system of its own size that one process and its children see and nobody else: a real disk
/// that can be full. Gone with the process.
class SmallDisk {
 public:
  /// Runs this program again, with the disk at `folder`.
  /// @return its exit status; `skipped`, with a word on stderr, where the kernel lets no one mount;
  /// 1, with the same word, where anything else is in the way
  static int RunAgainOn(const std::string& folder, int megabytes, char** argv, int skipped) {
    const pid_t child = fork();
    if (child == 0) {  // without the threads that libraries begin: a condition of the namespace
      // Mounting is root's, or anybody's in a user namespace of their own.
      const std::string size = "size=" + std::to_string(megabytes) + "m";
      const char* what = "a mount namespace";
      bool may_skip = true;
      if (unshare(CLONE_NEWNS) == 0 || OwnUserNamespace()) {
        what = "a tmpfs";
        if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
            mount("kerf-test", folder.c_str(), "tmpfs", 0, size.c_str()) == 0) {
          what = "the test";
          may_skip = false;
          execv("/proc/self/exe", argv);
        }
      }
      const int problem = errno;
      may_skip = may_skip && (problem == EPERM || problem == EACCES || problem == ENOSYS);
      std::fprintf(stderr, "%s: the kernel refuses %s: %s\n", may_skip ? "skipped" : "failed", what,
                   std::strerror(problem));
      _exit(may_skip ? skipped : 1);
    }
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child) return 1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  }

  explicit SmallDisk(const std::string& folder) : folder_(folder) {}
  ~SmallDisk() { Free(); }
  long Left() const {
    struct statvfs now {};
    statvfs(folder_.c_str(), &now);
    return static_cast<long>(now.f_bavail * now.f_bsize);
  }
  /// Others fill the disk until no more than `bytes` are left.
  void FillUpTo(long bytes) {
    Free();
    const int file = open(Balloon().c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0600);
    const std::vector<char> some(4096);
    while (Left() > bytes && write(file, some.data(), some.size()) > 0) {
    }
    close(file);
  }
  /// They make room again.
  void Free() {
    std::error_code ignored;
    std::filesystem::remove(Balloon(), ignored);
  }

 private:
  static bool OwnUserNamespace() {
    const std::string user = std::to_string(getuid()), group = std::to_string(getgid());
    if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
    const auto write_to = [](const char* file, const std::string& text) {
      return bool(std::ofstream(file) << text << std::flush);
    };
    return write_to("/proc/self/setgroups", "deny") &&
           write_to("/proc/self/uid_map", user + " " + user + " 1") &&
           write_to("/proc/self/gid_map", group + " " + group + " 1");
  }
  std::string Balloon() const { return folder_ + "/of-others"; }
  std::string folder_;
};

}  // namespace kerf::testing
