#pragma once

#include <string>
#include <vector>

namespace kerf {

/// What the case browser shows of one case folder; reading it never fails.
struct CaseSummary {
  std::string folder, name;  ///< absolute path; its last part
  std::string pseudonym;
  std::string state;      ///< a few words: "ready for the operating room", "no camera yet"
  std::string problem;    ///< a sentence where the folder cannot be used; then the rest is empty
  std::string thumbnail;  ///< path of a picture, empty where there is none
  bool has_ct = false, has_segmentation = false, has_mesh = false, has_plan = false,
       has_camera = false, has_landmarks = false;
  int sessions = 0;
};

/// Looks at the manifest alone, without hashing the files: quick enough for a list.
CaseSummary SummarizeCase(const std::string& folder);

/// The recent cases, newest first. Values in, values out; where they are kept is the window's
/// matter.
class RecentCases {
 public:
  explicit RecentCases(std::vector<std::string> folders = {}, std::size_t limit = 12);
  void Add(const std::string& folder);
  void Remove(const std::string& folder);
  const std::vector<std::string>& Folders() const { return folders_; }

 private:
  std::vector<std::string> folders_;
  std::size_t limit_;
};

}  // namespace kerf
