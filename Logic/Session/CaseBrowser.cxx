#include "Session/CaseBrowser.h"

#include <algorithm>
#include <filesystem>

#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

int CountFolders(const fs::path& folder) {
  std::error_code error;
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder, error)) count += entry.is_directory();
  return count;
}

std::string StateOf(const CaseSummary& s) {
  if (!s.has_mesh) return "not meshed yet";
  if (!s.has_camera) return "planned, no camera yet";
  const std::string ready = "ready for the operating room";
  if (s.sessions == 0) return ready;
  return ready + ", " + std::to_string(s.sessions) +
         (s.sessions == 1 ? " session recorded" : " sessions recorded");
}

}  // namespace

CaseSummary SummarizeCase(const std::string& folder) {
  CaseSummary summary;
  summary.folder = fs::absolute(folder).lexically_normal().string();
  while (summary.folder.size() > 1 && summary.folder.back() == '/') summary.folder.pop_back();
  summary.name = fs::path(summary.folder).filename().string();
  try {
    const CaseFolder opened = CaseFolder::Open(summary.folder, false);
    summary.pseudonym = opened.Manifest().pseudonym;
    summary.has_ct = opened.Has("ct");
    summary.has_segmentation = opened.Has("segmentation");
    summary.has_mesh = opened.Has("organ_mesh");
    summary.has_plan = opened.Has("plan");
    summary.has_camera = opened.Has("camera");
    summary.has_landmarks = opened.Has("landmarks");
    if (opened.Has("preview")) summary.thumbnail = opened.Path("preview");
    summary.sessions = CountFolders(fs::path(summary.folder) / "sessions");
    summary.state = StateOf(summary);
  } catch (const InputError& error) {
    summary.problem = error.what();
  }
  return summary;
}

RecentCases::RecentCases(std::vector<std::string> folders, std::size_t limit)
    : folders_(std::move(folders)), limit_(limit) {}

void RecentCases::Add(const std::string& folder) {
  Remove(folder);
  folders_.insert(folders_.begin(), folder);
  if (folders_.size() > limit_) folders_.resize(limit_);
}

void RecentCases::Remove(const std::string& folder) {
  folders_.erase(std::remove(folders_.begin(), folders_.end(), folder), folders_.end());
}

}  // namespace kerf
