#include "Pipelines/SessionFolder.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "CaseIO/AtomicFile.h"
#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {

std::string MakeSessionFolder(const std::string& case_folder, const std::string& time) {
  const fs::path base = fs::path(case_folder) / "sessions";
  std::error_code error;
  fs::create_directories(base, error);
  for (int attempt = 1; attempt < 100; ++attempt) {
    const fs::path folder = base / (attempt == 1 ? time : time + "-" + std::to_string(attempt));
    if (fs::create_directory(folder, error)) return folder.string();
    if (error) break;
  }
  throw InputError((base / time).string(), "",
                   "cannot be made: " + (error ? error.message() : "too many of this time"));
}

bool IsSessionFolder(const std::string& folder) {
  return fs::is_regular_file(fs::path(folder) / "session.json");
}

void WriteSession(const SessionFolder& session) {
  nlohmann::ordered_json json;
  json["format"] = "kerf-session";
  json["schema"] = SessionFolder::kSchema;
  json["notice"] = "Research use, not a medical device.";
  json["pseudonym"] = session.pseudonym;
  json["source"] = {{"file", session.source},
                    {"name", session.source_name},
                    {"frames_per_second", session.frames_per_second}};
  json["hold_cuts"] = session.hold_cuts;
  json["wanted_features"] = session.wanted_features;
  json["finished"] = session.finished;
  AtomicFile file((fs::path(session.root) / "session.json").string());
  file.Stream() << json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  file.Commit();
}

SessionFolder ReadSession(const std::string& folder) {
  const std::string path = (fs::path(folder) / "session.json").string();
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be read");
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object()) throw InputError(path, "", "is not JSON");
  if (json.value("format", "") != "kerf-session")
    throw InputError(path, "format", "is not \"kerf-session\"");
  SessionFolder session;
  try {
    if (json.at("schema").get<int>() > SessionFolder::kSchema)
      throw InputError(path, "schema", "is newer than this program: update Kerf");
    session.pseudonym = json.at("pseudonym").get<std::string>();
    session.source = json.at("source").at("file").get<std::string>();
    session.source_name = json.at("source").at("name").get<std::string>();
    session.frames_per_second = json.at("source").at("frames_per_second").get<double>();
    session.hold_cuts = json.at("hold_cuts").get<bool>();
    session.wanted_features = json.at("wanted_features").get<int>();
    session.finished = json.at("finished").get<bool>();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, "", std::string("a key is missing or of a wrong type: ") + error.what());
  }
  if (fs::path(session.source).filename().string() != session.source)
    throw InputError(path, "source.file", "is not a file of the session");
  if (!(session.frames_per_second > 0))
    throw InputError(path, "source.frames_per_second", "must be positive");
  session.root = folder;
  fs::path clean = fs::absolute(folder).lexically_normal();
  if (!clean.has_filename()) clean = clean.parent_path();
  session.case_folder = clean.parent_path().parent_path().string();
  return session;
}

namespace {

/// Sessions that `wanted` says yes to, newest first.
template <class Wanted>
std::vector<std::string> SessionsOf(const std::string& case_folder, Wanted wanted) {
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(case_folder) / "sessions", error)) {
    if (!IsSessionFolder(entry.path().string())) continue;
    try {
      if (fs::exists(entry.path() / "frames.csv") && wanted(ReadSession(entry.path().string())))
        found.push_back(entry.path().string());
    } catch (const InputError&) {  // a broken one is nothing to go on with
    }
  }
  std::sort(found.rbegin(), found.rend());
  return found;
}

}  // namespace

std::vector<std::string> RecordedSessions(const std::string& case_folder) {
  return SessionsOf(case_folder, [](const SessionFolder& session) {
    return !ReadRecordedFrames(session.root).empty();
  });
}

std::vector<std::string> UnfinishedSessions(const std::string& case_folder) {
  return SessionsOf(case_folder, [](const SessionFolder& session) { return !session.finished; });
}

void WritePicture(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream file(path, std::ios::binary);
  if (!file) throw InputError(path, "", std::string("cannot be written: ") + strerror(errno));
  try {
    WriteThrough(&file, path, {bytes.begin(), bytes.end()});
  } catch (const InputError&) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw;
  }
}

std::vector<std::string> KeptPictures(const std::string& session_folder) {
  std::vector<std::pair<std::pair<std::string, int>, std::string>> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(fs::path(session_folder) / "snapshots", none)) {
    if (entry.path().extension() != ".png") continue;
    const std::string stem = entry.path().stem().string();
    const auto dash = stem.rfind('-');
    const int again = dash == std::string::npos ? 1 : std::atoi(stem.c_str() + dash + 1);
    found.push_back({{stem.substr(0, dash), again}, entry.path().string()});
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> pictures;
  for (auto& [order, path] : found) pictures.push_back(std::move(path));
  return pictures;
}

std::vector<RecordedFrame> ReadRecordedFrames(const std::string& session_folder) {
  const std::string path = (fs::path(session_folder) / "frames.csv").string();
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be read");
  std::string line;
  std::getline(in, line);
  std::vector<RecordedFrame> frames;
  while (std::getline(in, line)) {
    if (in.eof()) break;
    std::istringstream fields(line);
    fields.imbue(std::locale::classic());
    RecordedFrame frame;
    char comma = 0;
    if (!(fields >> frame.number >> comma >> frame.source_frame >> comma >> frame.time_s) ||
        frame.number != static_cast<int>(frames.size()))
      throw InputError(path, "line " + std::to_string(frames.size() + 2), "is no recorded frame");
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace kerf
