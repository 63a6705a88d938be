#pragma once

#include <stdexcept>
#include <string>

namespace kerf {

/// A broken input from outside: names the file and the element. The shell exits with 3.
class InputError : public std::runtime_error {
 public:
  /// @param file path as the user gave it; @param element what in it (line, key, slice, triangle
  /// …), may be empty
  InputError(const std::string& file, const std::string& element, const std::string& problem);
  const std::string& File() const { return file_; }
  const std::string& Element() const { return element_; }

 private:
  std::string file_, element_;
};

/// Wrong use of a command or an option. The shell exits with 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The user cancelled (Ctrl-C, button). The shell exits with 130.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace kerf
