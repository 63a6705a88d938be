#include "Session/ResectionFiles.h"

#include <filesystem>

#include "CaseIO/Markups.h"

namespace kerf {
namespace {

constexpr char kResection[] = "plan/resection.mrk.json";

bool IsResection(const std::string& path) {
  return std::filesystem::path(path).filename() == std::filesystem::path(kResection).filename();
}

double NumberOf(const std::map<std::string, std::string>& provenance, const std::string& key,
                double otherwise) {
  const auto found = provenance.find(key);
  if (found == provenance.end()) return otherwise;
  try {
    return std::stod(found->second);
  } catch (const std::exception&) {
    return otherwise;
  }
}

Points Places(const MarkupList& list) {
  Points places(static_cast<Index>(list.points.size()), 3);
  for (std::size_t p = 0; p < list.points.size(); ++p)
    places.row(static_cast<Index>(p)) = list.points[p].position_mm.transpose();
  return places;
}

}  // namespace

ResectionPlan ReadResectionPlan(const CaseFolder& folder) {
  ResectionPlan plan;
  for (const std::string& path : folder.Paths("plan")) {
    if (!IsResection(path)) continue;
    for (const MarkupList& list : ReadMarkups(path)) plan.line = Places(list);
  }
  const auto& provenance = folder.Manifest().provenance;
  plan.margin_mm = NumberOf(provenance, "plan_margin_mm", plan.margin_mm);
  plan.depth_mm = NumberOf(provenance, "plan_depth_mm", plan.depth_mm);
  for (int a = 0; a < 3; ++a)
    plan.direction[a] =
        NumberOf(provenance, std::string("plan_direction_") + "xyz"[a], plan.direction[a]);
  plan.follows_surface = false;  // the saved direction stays
  return plan;
}

void StageResectionPlan(const ResectionPlan& plan, CaseWriter* writer) {
  writer->Remove(kResection);
  if (plan.line.rows() > 0) {
    MarkupList curve{"Curve", {}};
    for (Index p = 0; p < plan.line.rows(); ++p)
      curve.points.push_back({"resection-" + std::to_string(p + 1), plan.line.row(p).transpose()});
    WriteMarkups(writer->Stage(kResection, "plan"), {curve});
  }
  auto& provenance = writer->Manifest().provenance;
  provenance["plan_margin_mm"] = std::to_string(plan.margin_mm);
  provenance["plan_depth_mm"] = std::to_string(plan.depth_mm);
  for (int a = 0; a < 3; ++a)
    provenance[std::string("plan_direction_") + "xyz"[a]] = std::to_string(plan.direction[a]);
}

std::vector<Points> ReadOtherPlannedLines(const CaseFolder& folder) {
  std::vector<Points> lines;
  for (const std::string& path : folder.Paths("plan")) {
    if (IsResection(path)) continue;
    for (const MarkupList& list : ReadMarkups(path))
      if (list.type != "Fiducial" && list.points.size() > 1) lines.push_back(Places(list));
  }
  return lines;
}

}  // namespace kerf
