#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "Core/Errors.h"
#include "Core/Progress.h"
#include "Logic/CaseIO/TemporaryFolder.h"

namespace kerf::testing {

/// Keeps what was warned of.
class Listener : public Progress {
 public:
  void Warn(const std::string& message) override { warnings.push_back(message); }
  bool Heard(const std::string& part) const {
    for (const auto& w : warnings)
      if (w.find(part) != std::string::npos) return true;
    return false;
  }
  std::vector<std::string> warnings;
};

class FolderTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return temporary_ / name; }
  std::string ReadBytes(const std::string& path) const { return temporary_.Read(path); }
  void WriteBytes(const std::string& path, const std::string& bytes) const {
    temporary_.Write(path, bytes);
  }

 private:
  const TemporaryFolder temporary_;

 protected:
  const std::filesystem::path folder_ = temporary_.Path();
};

/// Message of the InputError that `action` throws, "" when there is none. Other exceptions fail the
/// test.
template <class Action>
std::string InputErrorOf(Action&& action) {
  try {
    action();
  } catch (const InputError& error) {
    EXPECT_FALSE(error.File().empty());
    return error.what();
  }
  return "";
}

inline ::testing::AssertionResult Says(const std::string& message, const std::string& part) {
  if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "'" << message << "' does not say '" << part << "'";
}

inline std::string DataFolder() {
  const char* own = std::getenv("KERF_DATA");
  return own ? own : KERF_DATA_DEFAULT;
}

}  // namespace kerf::testing
