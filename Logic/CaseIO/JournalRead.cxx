#include "CaseIO/JournalRead.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "Core/Errors.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

std::optional<JournalValue> Value(const Json& v) {
  if (v.is_boolean()) return JournalValue(v.get<bool>());
  if (v.is_number_integer()) return JournalValue(v.get<std::int64_t>());
  if (v.is_number()) return JournalValue(v.get<double>());
  if (v.is_string()) return JournalValue(v.get<std::string>());
  if (!v.is_array()) return std::nullopt;
  bool numbers = true;
  for (const auto& item : v) numbers = numbers && item.is_number();
  if (numbers) return JournalValue(v.get<std::vector<double>>());
  std::vector<std::string> texts;
  for (const auto& item : v)
    texts.push_back(item.is_string() ? item.get<std::string>() : item.dump());
  return JournalValue(texts);
}

template <class T>
const T* Find(const JournalData& data, const std::string& key) {
  for (const auto& [name, value] : data)
    if (name == key) return std::get_if<T>(&value.value);
  return nullptr;
}

}  // namespace

const std::string* JournalEntry::Text(const std::string& key) const {
  return Find<std::string>(data, key);
}

std::optional<double> JournalEntry::Number(const std::string& key) const {
  if (const auto* v = Find<double>(data, key)) return *v;
  if (const auto* v = Find<std::int64_t>(data, key)) return static_cast<double>(*v);
  return std::nullopt;
}

std::vector<double> JournalEntry::Numbers(const std::string& key) const {
  const auto* v = Find<std::vector<double>>(data, key);
  return v ? *v : std::vector<double>();
}

std::vector<JournalEntry> ReadJournal(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be read");
  std::vector<JournalEntry> entries;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (in.eof()) break;  // no end of line: cut off while it was written
    const Json json = Json::parse(line, nullptr, false);
    const std::string where = "line " + std::to_string(number);
    if (!json.is_object() || !json.contains("event") || !json["event"].is_string())
      throw InputError(path, where, "is no journal entry");
    JournalEntry entry;
    entry.event = json["event"].get<std::string>();
    if (json.contains("time_s") && json["time_s"].is_number()) entry.time_s = json["time_s"];
    if (json.contains("frame") && json["frame"].is_number_integer()) entry.frame = json["frame"];
    if (json.contains("data") && json["data"].is_object())
      for (const auto& [key, v] : json["data"].items())
        if (auto value = Value(v)) entry.data.push_back({key, std::move(*value)});
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace kerf
