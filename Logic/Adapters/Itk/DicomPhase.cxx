#include "Adapters/Itk/DicomPhase.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <optional>
#include <utility>

namespace kerf {
namespace {

/// Longer names come before those that they contain.
constexpr std::pair<const char*, const char*> kNames[] = {
    {"portalven", "portal venous"}, {"portal", "portal venous"}, {"porto", "portal venous"},
    {"nephro", "nephrographic"},    {"corticomed", "arterial"},  {"urogra", "excretory"},
    {"excret", "excretory"},        {"arteri", "arterial"},      {"arter", "arterial"},
    {"venous", "venous"},           {"ven\xc3\xb6s", "venous"},  {"venoes", "venous"},
    {"veineu", "venous"},           {"delay", "delayed"},        {"late", "delayed"},
    {"sp\xc3\xa4t", "delayed"},     {"spaet", "delayed"},        {"tardif", "delayed"},
    {"non-contrast", "native"},     {"noncontrast", "native"},   {"without contrast", "native"},
    {"unenhanced", "native"},       {"nativ", "native"},         {"sans inj", "native"}};

/// HHMMSS.F as seconds of the day.
std::optional<double> Seconds(const std::string& time) {
  if (time.size() < 6 ||
      !std::all_of(time.begin(), time.begin() + 6, [](unsigned char c) { return std::isdigit(c); }))
    return std::nullopt;
  return std::atoi(time.substr(0, 2).c_str()) * 3600.0 +
         std::atoi(time.substr(2, 2).c_str()) * 60.0 + std::atof(time.substr(4).c_str());
}

}  // namespace

std::string ContrastPhase(const ContrastTags& tags) {
  std::string text = tags.description;
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::string phase;
  for (const auto& [part, name] : kNames)
    if (phase.empty() && text.find(part) != std::string::npos) phase = name;
  if (phase.empty() && !tags.agent.empty()) phase = "contrast";
  if (phase.empty() || phase == "native") return phase;
  const auto injected = Seconds(tags.injection_time), acquired = Seconds(tags.acquisition_time);
  if (!injected || !acquired) return phase;
  const double after_s = *acquired - *injected;
  if (after_s <= 0 || after_s > 3600) return phase;  // of another scan, or past midnight
  return phase + ", " + std::to_string(static_cast<int>(after_s + 0.5)) + " s";
}

std::string LateralityInWords(const std::string& code) {
  if (code == "L") return "left";
  if (code == "R") return "right";
  if (code == "B") return "both";
  return {};
}

std::string PersonName(const std::string& dicom) {
  // Components: family^given^middle^prefix^suffix; ideographic groups after '='.
  std::string name, part;
  int component = 0;
  for (const char c : dicom.substr(0, dicom.find('=')) + '^') {
    if (c != '^') {
      part += c;
      continue;
    }
    while (!part.empty() && part.back() == ' ') part.pop_back();
    if (!part.empty() && component < 3)
      name += (name.empty() ? "" : component == 1 ? ", " : " ") + part;
    part.clear();
    ++component;
  }
  return name;
}

}  // namespace kerf
