#include <fmt/format.h>

#include "Commands.h"
#include "Pipelines/PlanPipeline.h"

namespace kerf {
namespace {

void Run(CommandContext& context, const PlanRequest& request, const std::string& output) {
  context.progress = MakeShellProgress(context.quiet);
  const PlannedCase planned = Plan(request, *context.progress);
  WriteCase(planned, output, {{"program", std::string("kerf ") + KERF_VERSION}});
  const MeshQuality& q = planned.report.quality;
  nlohmann::json structures = nlohmann::json::array();
  for (const Structure& s : planned.structures)
    structures.push_back({{"name", s.name},
                          {"points", s.rest.points.rows()},
                          {"triangles", s.rest.triangles.rows()},
                          {"volume_ml", s.rest.SignedVolume() / 1000.0}});
  context.result = {{"case", output},
                    {"tetrahedra", q.tets},
                    {"vertices", q.vertices},
                    {"smallest_dihedral_deg", q.smallest_dihedral_deg},
                    {"manifold_boundary", q.manifold_boundary},
                    {"components", q.components},
                    {"volume_ml", q.volume_mm3 / 1000.0},
                    {"input_volume_ml", planned.report.input_volume_mm3 / 1000.0},
                    {"volume_error", planned.report.volume_error},
                    {"edge_mm", planned.report.edge_mm},
                    {"points_outside", planned.embedding.outside},
                    {"largest_distance_outside_mm", planned.embedding.largest_distance_mm},
                    {"structures", structures}};
  context.Print(
      fmt::format("Organ: {} tetrahedra, {} vertices, smallest dihedral angle {:.1f} degrees, "
                  "{:.1f} mL ({:+.2f} % of the input)",
                  q.tets, q.vertices, q.smallest_dihedral_deg, q.volume_mm3 / 1000.0,
                  100.0 * planned.report.volume_error));
  for (const Structure& s : planned.structures)
    context.Print(fmt::format("{}: {} points, {} triangles, {:.2f} mL", s.name,
                              s.rest.points.rows(), s.rest.triangles.rows(),
                              s.rest.SignedVolume() / 1000.0));
  if (!planned.structures.empty())
    context.Print(fmt::format("Embedded points outside the organ mesh: {} (at most {:.2f} mm)",
                              planned.embedding.outside, planned.embedding.largest_distance_mm));
  context.Print("Case: " + output + "\nResearch use, not a medical device.");
}

}  // namespace

void AddPlanCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c = app.add_subcommand(
      "plan", "CT or surface -> segmentation, tetrahedral mesh, inner structures -> case folder");
  auto request = std::make_shared<PlanRequest>();
  auto output = std::make_shared<std::string>();
  c->add_option("INPUT", request->input,
                "CT (DICOM folder, NIfTI, NRRD), or a closed surface (.stl .vtp .ply .obj)")
      ->required();
  c->add_option("--output", *output, "case folder; an older case there is replaced")->required();
  c->add_option("--preset", request->preset, "organ to be segmented")
      ->check(CLI::IsMember({"liver", "kidney"}));
  c->add_option("--seeds", request->seeds_file,
                "Slicer markups (.mrk.json); each control point's label is organ, tumour, internal "
                "or background");
  c->add_option("--labels", request->labels_file,
                "finished label map: 1 organ, 2 tumour, 3 inner structure");
  c->add_option("--series", request->series_uid,
                "SeriesInstanceUID, where a DICOM folder holds several");
  c->add_option("--camera", request->camera_file, "calibrated camera (camera.yml) for the case");
  c->add_option("--landmarks", request->landmarks_file,
                "landmarks for the initial registration, for the case: Slicer markups (.mrk.json) "
                "or a study's landmarks.csv");
  c->add_option("--tetrahedra", request->meshing.tetrahedra, "wanted size of the organ mesh")
      ->check(CLI::Range(200, 1000000))
      ->capture_default_str();
  AddCommonOptions(c, &context);
  c->footer(
      "Examples:\n"
      "  kerf plan ct.nii.gz --labels labels.nii.gz --output case\n"
      "  kerf plan dicom-folder --preset liver --output case\n"
      "  kerf plan ct.nrrd --preset kidney --seeds seeds.mrk.json --output case\n"
      "  kerf plan band.stl --tetrahedra 6000 --output case\n"
      "Exit status: 0 done, 2 wrong use, 3 bad input, 130 cancelled.");
  c->callback([request, output, &context] { Run(context, *request, *output); });
}

}  // namespace kerf
