#include "Adapters/Itk/Preset.h"

#include <nlohmann/json.hpp>

#include "Adapters/Itk/PresetTexts.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

using nlohmann::json;

OrganKnowledge Parse(const char* text) {
  const json document = json::parse(text);
  OrganKnowledge k;
  k.name = document.at("name");
  k.seed_hu = document.at("seed_hu");
  k.window_hu = document.at("window_hu");
  k.reach_mm = document.at("reach_mm");
  k.volume_ml = document.at("volume_ml");
  k.neck_ratio = document.at("neck_ratio");
  k.working_spacing_mm = document.at("working_spacing_mm");
  k.thin_mm = document.at("thin_mm");
  k.closing_mm = document.at("closing_mm");
  k.follow_drift = document.at("follow_drift");
  k.rib_gap_mm = document.at("rib_gap_mm");
  const json& tumour = document.at("tumour");
  k.tumour = {tumour.at("contrast_hu"), tumour.at("enclosed"), tumour.at("least_ml")};
  const json& internal = document.at("internal");
  k.internal = {internal.at("contrast_hu"), 1.0, internal.at("least_ml")};
  return k;
}

}  // namespace

const OrganKnowledge& KnowledgeOf(OrganPreset preset) {
  static const OrganKnowledge liver = Parse(kLiverPreset), kidney = Parse(kKidneyPreset);
  return preset == OrganPreset::Liver ? liver : kidney;
}

OrganPreset ParseOrganPreset(const std::string& name) {
  if (name == "liver") return OrganPreset::Liver;
  if (name == "kidney") return OrganPreset::Kidney;
  throw UsageError("unknown preset '" + name + "': liver or kidney");
}

std::string ToString(OrganPreset preset) { return KnowledgeOf(preset).name; }

}  // namespace kerf
