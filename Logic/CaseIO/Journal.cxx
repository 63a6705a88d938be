#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "CaseIO/AtomicFile.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Errors.h"

namespace kerf {

Journal::Journal(const std::string& path, bool append) : path_(path) {
  const auto parent = std::filesystem::path(path).parent_path();
  std::error_code error;
  if (!parent.empty()) std::filesystem::create_directories(parent, error);
  stream_.open(path, std::ios::binary | (append ? std::ios::app : std::ios::trunc));
  if (!stream_) throw InputError(path, "", std::string("cannot be written: ") + strerror(errno));
}

void Journal::Write(double time_s, int frame, const std::string& event, const JournalData& data) {
  nlohmann::ordered_json entry;
  // Milliseconds are enough for a video frame, and keep the lines readable.
  entry["time_s"] = std::round(time_s * 1e3) / 1e3;
  entry["frame"] = frame;
  entry["event"] = event;
  auto values = nlohmann::ordered_json::object();
  for (const auto& [key, item] : data)
    std::visit([&, k = key](const auto& v) { values[k] = v; }, item.value);
  entry["data"] = std::move(values);
  WriteThrough(&stream_, path_,
               entry.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
}

}  // namespace kerf
