#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>

#include "Adapters/OpenCv/CameraCalibration.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/ImageSequence.h"
#include "Commands.h"

namespace kerf {
namespace {

struct CalibrateOptions {
  std::vector<std::string> images;
  std::string board = "chessboard", output;
  CalibrationBoard print;
};

/// Folders stand for the images in them.
std::vector<std::string> Expand(const std::vector<std::string>& images) {
  std::vector<std::string> files;
  for (const std::string& image : images) {
    if (!std::filesystem::is_directory(image) && image.find('%') == std::string::npos) {
      files.push_back(image);
      continue;
    }
    const ImageSequence sequence = ListImageSequence(image);
    files.insert(files.end(), sequence.files.begin(), sequence.files.end());
  }
  return files;
}

void Report(const CalibrationResult& result, const CalibrateOptions& options,
            CommandContext& context) {
  char line[300];
  nlohmann::json views = nlohmann::json::array();
  for (const CalibrationView& view : result.views) {
    if (view.problem.empty())
      std::snprintf(line, sizeof line, "  %-40s %4d corners  %.3f px", view.file.c_str(),
                    view.corners, view.rms_px);
    else
      std::snprintf(line, sizeof line, "  %-40s left out: %s", view.file.c_str(),
                    view.problem.c_str());
    context.Print(line);
    views.push_back({{"file", view.file},
                     {"corners", view.corners},
                     {"rms_px", view.rms_px},
                     {"problem", view.problem}});
  }
  const CameraModel& c = result.camera;
  std::snprintf(line, sizeof line,
                "Focal length %.2f, %.2f px (± %.2f); centre %.2f, %.2f px; distortion %.4f %.4f "
                "%.5f %.5f %.4f",
                c.fx, c.fy, result.focal_deviation_px, c.cx, c.cy, c.distortion[0], c.distortion[1],
                c.distortion[2], c.distortion[3], c.distortion[4]);
  context.Print(line);
  std::snprintf(line, sizeof line, "Reprojection error %.3f px. Written to %s", result.rms_px,
                options.output.c_str());
  context.Print(line);
  for (const std::string& warning : result.warnings) context.progress->Warn(warning);
  context.result = {{"output", options.output},
                    {"rms_px", result.rms_px},
                    {"focal_px", {c.fx, c.fy}},
                    {"focal_deviation_px", result.focal_deviation_px},
                    {"center_px", {c.cx, c.cy}},
                    {"distortion", c.distortion},
                    {"image_size_px", {c.width, c.height}},
                    {"views", views},
                    {"warnings", result.warnings}};
}

}  // namespace

void AddCalibrateCommand(CLI::App& app, CommandContext& context) {
  CLI::App* command =
      app.add_subcommand("calibrate", "camera intrinsics and distortion from pictures of a board");
  auto options = std::make_shared<CalibrateOptions>();
  command
      ->add_option("images", options->images,
                   "pictures of the board: files, folders, patterns such as b%02d.png")
      ->required();
  command->add_option("--board", options->board, "chessboard or charuco")
      ->required()
      ->check(CLI::IsMember({"chessboard", "charuco"}));
  command->add_option("--columns", options->print.columns, "squares in a row of the print")
      ->required();
  command->add_option("--rows", options->print.rows, "squares in a column of the print")
      ->required();
  command->add_option("--square", options->print.square_mm, "side of a square, mm")->required();
  command->add_option("--marker", options->print.marker_mm, "charuco: side of a marker, mm");
  command->add_option("--dictionary", options->print.dictionary, "charuco: marker dictionary")
      ->capture_default_str();
  command->add_option("--output", options->output, "camera file to write, camera.yml")->required();
  AddCommonOptions(command, &context);
  command->footer(
      "Columns and rows count squares, not inner corners. Take 10 to 20 pictures with the focus of "
      "the\n"
      "operation, the board tilted and in every part of the image.\n\n"
      "Examples:\n"
      "  kerf calibrate pictures/ --board chessboard --columns 10 --rows 7 --square 4 --output "
      "camera.yml\n"
      "  kerf calibrate c*.png --board charuco --columns 11 --rows 8 --square 5 --marker 3.7 "
      "--output camera.yml");
  command->callback([&context, options] {
    context.progress = MakeShellProgress(context.quiet);
    options->print.kind = options->board == "charuco" ? BoardKind::Charuco : BoardKind::Chessboard;
    const CalibrationResult result =
        CalibrateCamera(Expand(options->images), options->print, *context.progress);
    char today[32];
    const std::time_t now = std::time(nullptr);
    std::strftime(today, sizeof today, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
    WriteCameraFile(options->output, result.camera, today);
    Report(result, *options, context);
  });
}

}  // namespace kerf
