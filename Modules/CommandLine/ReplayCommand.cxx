#include <fmt/format.h>

#include <sstream>

#include "Commands.h"
#include "Pipelines/ReplayPipeline.h"

namespace kerf {
namespace {

struct ReplayArguments {
  ReplayRequest request;
  std::string labels, method = "kerf", cutting = "on", registration = "given", render = "on",
                      grips = "on", outline = "on", extrusion;
  double young_kPa = 0, poisson = 0, spring = 0, neighbour_radius_mm = 0, tau = 0,
         cut_radius_mm = 0, cut_depth_mm = 0;
  int outliers = 0, steps = 0, tetrahedra = 0;
  std::string case_folder, tracks;
};

Vec3 ParseDirection(const std::string& text) {
  Vec3 v = Vec3::Zero();
  char comma1 = 0, comma2 = 0;
  std::istringstream stream(text);
  if (!(stream >> v.x() >> comma1 >> v.y() >> comma2 >> v.z()) || comma1 != ',' || comma2 != ',' ||
      !(stream >> std::ws).eof() || !v.allFinite() || v.norm() < 1e-9)
    throw UsageError("--extrusion: expected camera or x,y,z (LPS, not 0,0,0), got " + text);
  return v.normalized();
}

/// The method's options with what the user gave; the names given are kept, they win over the
/// study's suggestions.
void BuildRequest(const CLI::App& command, const CommandContext& context, ReplayArguments* a) {
  ReplayRequest& r = a->request;
  r.method = a->method == "reference" ? ReferenceOptions() : MethodOptions();
  r.method.cutting = a->cutting == "on";
  if (a->grips == "off") r.method.grips = false;
  r.outline = a->outline == "on";
  if (a->render == "off") r.drawing = ReplayRequest::Drawing::None;
  r.threads = context.threads;
  r.labels = a->labels == "given"     ? ReplayRequest::Labels::Given
             : a->labels == "segment" ? ReplayRequest::Labels::Segment
                                      : ReplayRequest::Labels::Automatic;
  if (a->registration == "landmarks") r.registration = ReplayRequest::InitialPose::Landmarks;
  const auto given = [&](const char* name) {
    if (command.count(std::string("--") + name) == 0) return false;
    r.given.insert(name);
    return true;
  };
  if (given("case")) r.case_folder = a->case_folder;
  if (given("tracks")) r.tracks = a->tracks;
  if (given("tetrahedra")) r.tetrahedra = a->tetrahedra;
  if (given("steps-per-frame")) r.method.steps_per_frame = a->steps;
  if (given("young")) r.method.material.young_kPa = a->young_kPa;
  if (given("poisson")) r.method.material.poisson = a->poisson;
  if (given("spring")) r.method.spring_g_s2 = a->spring;
  if (given("neighbour-radius")) r.method.neighbour_radius_mm = a->neighbour_radius_mm;
  if (given("tau")) r.method.tau = a->tau;
  if (given("outliers")) r.method.outliers = a->outliers;
  if (given("cut-radius")) r.method.cut_radius_mm = a->cut_radius_mm;
  if (given("cut-depth")) r.method.cut_depth_mm = a->cut_depth_mm;
  if (given("extrusion") && a->extrusion != "camera")
    r.method.extrusion = ParseDirection(a->extrusion);
  r.method.Validate();
}

/// One line for each landmark that the initial registration was made from.
void PrintLandmarks(const std::vector<LandmarkFit>& landmarks, CommandContext& context) {
  if (landmarks.empty()) return;
  std::string text = "Initial registration from landmarks, residuals:\n";
  context.result["landmarks"] = nlohmann::json::array();
  for (const LandmarkFit& fit : landmarks) {
    text += fmt::format("  landmark {:<4} {:6.2f} px {:6.2f} mm{}\n", fit.id, fit.residual_px,
                        fit.residual_mm, fit.outlier ? "   outlier: contradicts the others" : "");
    context.result["landmarks"].push_back({{"id", fit.id},
                                           {"residual_px", fit.residual_px},
                                           {"residual_mm", fit.residual_mm},
                                           {"outlier", fit.outlier}});
  }
  text.pop_back();
  context.Print(text);
}

void Run(const CLI::App& command, CommandContext& context, ReplayArguments* a) {
  context.progress = MakeShellProgress(context.quiet);
  BuildRequest(command, context, a);
  const ReplayResult result = Replay(a->request, *context.progress);
  context.progress->Report(1.0, "done");
  context.result = {{"frames", result.frames},
                    {"cuts", result.cuts},
                    {"gate", ToString(result.final_gate)},
                    {"reason", result.final_reason},
                    {"median_ms", result.median_ms},
                    {"p99_ms", result.p99_ms},
                    {"results", a->request.results}};
  if (result.broken) context.result["broken"] = *result.broken;
  PrintLandmarks(result.landmarks, context);
  context.Print(fmt::format(
      "{} frames, {} cut{}, gate {} at the end ({}); {:.1f} ms a frame (99 %: {:.1f} ms)\n"
      "Results: {}\nResearch use, not a medical device.",
      result.frames, result.cuts, result.cuts == 1 ? "" : "s", ToString(result.final_gate),
      result.final_reason, result.median_ms, result.p99_ms, a->request.results));
  if (result.broken)
    context.exit_status = 3;
  else if (result.final_gate == GateState::Off)
    context.exit_status = 4;
}

}  // namespace

void AddReplayCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c = app.add_subcommand("replay", "the whole intraoperative job over a recorded study");
  auto a = std::make_shared<ReplayArguments>();
  c->add_option("STUDY", a->request.study, "study folder, or a session: CASE/sessions/TIME")
      ->required();
  c->add_option("--output", a->request.results, "results folder")->required();
  c->add_option("--case", a->case_folder,
                "case folder planned before (default: plan from the study)");
  c->add_option("--labels", a->labels, "use the study's label map, or segment its CT")
      ->check(CLI::IsMember({"given", "segment"}));
  c->add_option("--tracks", a->tracks, "perfect tracks (features_2d.csv) instead of the video");
  c->add_option("--method", a->method, "registration method")
      ->check(CLI::IsMember({"kerf", "reference"}))
      ->capture_default_str();
  c->add_option("--cutting", a->cutting, "detect and apply cuts")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  c->add_option("--registration", a->registration,
                "initial registration: camera.yml or landmarks.csv")
      ->check(CLI::IsMember({"given", "landmarks"}))
      ->capture_default_str();
  c->add_option("--outline", a->outline,
                "move an initial pose that contradicts the organ's outline in the first picture "
                "(kerf method, video)")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  c->add_option("--tetrahedra", a->tetrahedra, "size of the organ mesh")
      ->check(CLI::Range(200, 1000000));
  c->add_option("--threads", context.threads,
                "threads (0: all cores); the results do not depend on it")
      ->check(CLI::Range(0, 1024));
  c->add_option("--steps-per-frame", a->steps,
                "repeats of steps [2]-[8] of the method with one frame")
      ->check(CLI::Range(1, 1000));
  c->add_option("--grips", a->grips,
                "take depth from inferred grips (kerf method; off: for comparison)")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  c->add_option("--render", a->render, "write overlay.mp4")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  c->add_option("--young", a->young_kPa, "Young's modulus of the organ, kPa")->group("Method");
  c->add_option("--poisson", a->poisson, "Poisson's ratio, below 0.5")->group("Method");
  c->add_option("--spring", a->spring, "stiffness of a feature spring, g/s^2")->group("Method");
  c->add_option("--neighbour-radius", a->neighbour_radius_mm, "radius of the feature graph, mm")
      ->group("Method");
  c->add_option("--tau", a->tau, "outliers diverge more than tau times the mean")->group("Method");
  c->add_option("--outliers", a->outliers, "outliers that make a cut point")->group("Method");
  c->add_option("--cut-radius", a->cut_radius_mm, "radius around a cut point, mm")->group("Method");
  c->add_option("--extrusion", a->extrusion, "direction of the cut: camera, or x,y,z in LPS")
      ->group("Method");
  c->add_option("--cut-depth", a->cut_depth_mm,
                "depth of the cut below the surface, mm (default: through)")
      ->group("Method");
  AddCommonOptions(c, &context);
  c->footer(
      "Examples:\n"
      "  kerf replay study --output results\n"
      "  kerf replay study --output results --method reference --tracks study/features_2d.csv\n"
      "Exit status: 0 done, 2 wrong use, 3 bad input, 4 the gate is off at the end, 130 "
      "cancelled.");
  c->callback([c, a, &context] { Run(*c, context, a.get()); });
}

}  // namespace kerf
