#include <fcntl.h>
#include <linux/fs.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "CaseIO/AtomicFile.h"
#include "CaseIO/CaseFolder.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

fs::path WithoutTrailingSlash(const std::string& root) {
  fs::path path = fs::path(root).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path;
}

[[noreturn]] void Fail(const fs::path& path, const std::string& why) {
  throw InputError(path.string(), "", "cannot be written: " + why);
}

void LinkOrCopy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  fs::create_hard_link(from, to, error);
  if (!error) return;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) Fail(to, error.message());
}

/// A rename is durable once its folder is synced.
void SyncFolder(const fs::path& folder) {
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

/// Puts `stage` in the place of `root`; the old content, if any, is at `stage` afterwards.
void Swap(const fs::path& stage, const fs::path& root) {
  if (!fs::exists(root)) {
    if (::rename(stage.c_str(), root.c_str()) != 0) Fail(root, std::strerror(errno));
    return;
  }
  if (::renameat2(AT_FDCWD, stage.c_str(), AT_FDCWD, root.c_str(), RENAME_EXCHANGE) == 0) return;
  // File systems without an atomic exchange: the old case is kept under another name until the new
  // one stands.
  const fs::path aside = stage.string() + ".old";
  if (::rename(root.c_str(), aside.c_str()) != 0) Fail(root, std::strerror(errno));
  if (::rename(stage.c_str(), root.c_str()) != 0) {
    const std::string why = std::strerror(errno);
    ::rename(aside.c_str(), root.c_str());
    Fail(root, why);
  }
  if (::rename(aside.c_str(), stage.c_str()) != 0) Fail(stage, std::strerror(errno));
}

std::string ManifestText(const CaseManifest& manifest) {
  nlohmann::ordered_json json;
  json["format"] = "kerf-case";
  json["schema"] = CaseManifest::kSchema;
  json["notice"] = "Research use, not a medical device.";
  json["pseudonym"] = manifest.pseudonym;
  json["space"] = manifest.space;
  json["units"] = {{"length", "mm"}, {"time", "s"}, {"angle", "degrees"}, {"modulus", "kPa"}};
  json["provenance"] = nlohmann::ordered_json::object();
  for (const auto& [key, value] : manifest.provenance) json["provenance"][key] = value;
  json["files"] = nlohmann::ordered_json::array();
  for (const auto& file : manifest.files)
    json["files"].push_back(
        {{"path", file.path}, {"role", file.role}, {"sha256", file.sha256}, {"bytes", file.bytes}});
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

CaseWriter::CaseWriter(const std::string& root) : root_(WithoutTrailingSlash(root).string()) {
  const fs::path path(root_);
  if (fs::exists(path) && !fs::is_directory(path))
    throw UsageError(root_ + ": is a file, a folder is wanted");
  if (fs::is_directory(path) && !fs::is_empty(path) && FolderFormat(root_) != "kerf-case")
    throw UsageError(root_ + ": holds other files and is no case folder; choose another place");
  const fs::path parent = path.parent_path();
  std::error_code error;
  if (!parent.empty()) fs::create_directories(parent, error);
  const std::string name =
      "." + path.filename().string() + "." + std::to_string(::getpid()) + ".partial";
  stage_ = (parent / name).string();
  fs::remove_all(stage_, error);
  fs::create_directory(stage_, error);
  if (error) Fail(path, error.message());
}

CaseWriter CaseWriter::Update(const std::string& root) {
  const CaseFolder old = CaseFolder::Open(root);
  CaseWriter writer(root);
  writer.manifest_ = old.Manifest();
  for (const auto& file : old.Manifest().files) {
    LinkOrCopy(fs::path(root) / file.path, fs::path(writer.stage_) / file.path);
    writer.role_of_[file.path] = file.role;
  }
  return writer;
}

CaseWriter::CaseWriter(CaseWriter&& other) noexcept
    : root_(std::move(other.root_)),
      stage_(std::move(other.stage_)),
      manifest_(std::move(other.manifest_)),
      role_of_(std::move(other.role_of_)) {
  other.stage_.clear();
}

CaseWriter::~CaseWriter() {
  if (stage_.empty()) return;
  std::error_code ignored;
  fs::remove_all(stage_, ignored);
}

std::string CaseWriter::Stage(const std::string& relative, const std::string& role) {
  const fs::path path = fs::path(stage_) / relative;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  // A hard link shares its content with the old case: the new file must be a file of its own.
  fs::remove(path, error);
  role_of_[fs::path(relative).lexically_normal().generic_string()] = role;
  return path.string();
}

void CaseWriter::Remove(const std::string& relative) {
  std::error_code ignored;
  fs::remove(fs::path(stage_) / relative, ignored);
  role_of_.erase(fs::path(relative).lexically_normal().generic_string());
}

void CaseWriter::Commit() {
  manifest_.schema = CaseManifest::kSchema;
  manifest_.files.clear();
  for (const auto& [path, role] : role_of_) {
    const fs::path file = fs::path(stage_) / path;
    if (!fs::is_regular_file(file))
      throw InputError(path, "", "was announced for the case but never written");
    manifest_.files.push_back({path, role, Sha256OfFile(file.string()), fs::file_size(file)});
  }
  AtomicFile manifest((fs::path(stage_) / "case.json").string());
  manifest.Stream() << ManifestText(manifest_);
  manifest.Commit();
  SyncFolder(stage_);
  Swap(stage_, root_);
  // What is at stage_ now is the old case, or nothing.
  const fs::path old_sessions = fs::path(stage_) / "sessions";
  const fs::path new_sessions = fs::path(root_) / "sessions";
  std::error_code ignored;
  if (fs::is_directory(old_sessions) && !fs::exists(new_sessions))
    fs::rename(old_sessions, new_sessions, ignored);
  fs::remove_all(stage_, ignored);
  stage_.clear();
  SyncFolder(fs::path(root_).parent_path());
}

}  // namespace kerf
