#include "Pipelines/ExportPipeline.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/AtomicFile.h"
#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"
#include "Pipelines/DeformedLabels.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

/// What can be exported from a folder: names without extension, files as they are (LPS).
struct Source {
  std::string tetra_name, tetra_file;
  std::vector<std::pair<std::string, std::string>> surfaces;  ///< name, file
  std::string segmentation;  ///< label map at rest; empty where there is none
  bool deformed = false;     ///< the tetra mesh is not at rest: the label map moves with it
};

std::string In(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

Source OpenCase(const std::string& folder) {
  const CaseFolder opened = CaseFolder::Open(folder);
  Source source;
  source.tetra_name = "organ";
  source.tetra_file = opened.Path("organ_mesh");
  for (const char* role : {"organ_surface", "internal", "tumour"})
    if (opened.Has(role))
      source.surfaces.push_back({fs::path(opened.Path(role)).stem().string(), opened.Path(role)});
  if (opened.Has("segmentation")) source.segmentation = opened.Path("segmentation");
  return source;
}

/// The label map that was planned on; empty where there is none. The manifest tells its name; where
/// there is no manifest, it is the usual one.
std::string PlannedLabels(const std::string& case_folder) {
  if (case_folder.empty()) return {};
  if (FolderFormat(case_folder) == "kerf-case") {
    const CaseFolder opened = CaseFolder::Open(case_folder, false);
    return opened.Has("segmentation") ? opened.Path("segmentation") : std::string();
  }
  const std::string usual = In(case_folder, "segmentation.seg.nrrd");
  return fs::is_regular_file(usual) ? usual : std::string();
}

/// The case in which a session lies (CASE/sessions/<time>); empty for other results, which may lie
/// anywhere, in another patient's case, too.
std::string CaseOfSession(const std::string& folder) {
  const fs::path session = fs::canonical(folder), sessions = session.parent_path();
  const fs::path around = sessions.parent_path();
  const bool recorded = fs::is_regular_file(session / "session.json") &&
                        sessions.filename() == "sessions" &&
                        FolderFormat(around.string()) == "kerf-case";
  return recorded ? around.string() : std::string();
}

Source OpenResults(const std::string& folder) {
  Source source;
  source.deformed = true;
  source.tetra_name = "organ_final";
  source.tetra_file = In(folder, "organ_final.vtu");
  for (const char* name : {"internal_final", "tumour_final"})
    if (const std::string file = In(folder, std::string(name) + ".vtp"); fs::exists(file))
      source.surfaces.push_back({name, file});
  for (int k = 0;; ++k) {
    const std::string name = "cut_" + std::to_string(k) + "_surface";
    if (!fs::exists(In(folder, name + ".vtp"))) break;
    source.surfaces.push_back({name, In(folder, name + ".vtp")});
  }
  source.segmentation = PlannedLabels(In(folder, "case"));
  if (source.segmentation.empty()) source.segmentation = PlannedLabels(CaseOfSession(folder));
  return source;
}

Source OpenSource(const std::string& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder, "", "is no folder");
  if (FolderFormat(folder) == "kerf-case") return OpenCase(folder);
  if (fs::exists(In(folder, "organ_final.vtu"))) return OpenResults(folder);
  throw InputError(folder, "",
                   "is neither a case folder (case.json with \"kerf-case\") nor a results folder "
                   "(organ_final.vtu)");
}

std::string FlippedVector(const std::string& vector, const std::string& path) {
  // "(x,y,z)" → "(-x,-y,z)"; "none" stays.
  if (vector.size() < 2 || vector.front() != '(') return vector;
  std::istringstream parts(vector.substr(1, vector.size() - 2));
  std::string part, out = "(";
  for (int k = 0; k < 3; ++k) {
    if (!std::getline(parts, part, ',')) throw InputError(path, "header", "has a broken vector");
    if (k < 2) part = part[0] == '-' ? part.substr(1) : part == "0" ? part : "-" + part;
    out += part + (k < 2 ? "," : ")");
  }
  return out;
}

/// Rewrites the header of a .seg.nrrd from LPS to RAS: the same voxels at the same place, in other
/// words.
void RewriteAsRas(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream content;
  content << in.rdbuf();
  const std::string text = content.str();
  const auto end = text.find("\n\n");
  if (end == std::string::npos) throw InputError(path, "header", "has no end");
  std::istringstream header(text.substr(0, end + 1));
  std::string line, out;
  while (std::getline(header, line)) {
    if (line.rfind("space: ", 0) == 0) {
      line = "space: right-anterior-superior";
    } else if (line.rfind("space directions: ", 0) == 0 || line.rfind("space origin: ", 0) == 0) {
      std::istringstream words(line.substr(line.find(": ") + 2));
      line = line.substr(0, line.find(": ") + 1);
      std::string word;
      while (words >> word) line += " " + FlippedVector(word, path);
    }
    out += line + "\n";
  }
  AtomicFile file(path);
  file.Stream() << out << text.substr(end + 1);
  file.Commit();
}

void CheckFormat(const std::string& format) {
  static const char* known[] = {"vtu", "vtp", "stl", "ply", "obj", "glb", "seg.nrrd"};
  if (std::find(std::begin(known), std::end(known), format) == std::end(known))
    throw UsageError("export: unknown format \"" + format +
                     "\" (vtu, vtp, stl, ply, obj, glb, seg.nrrd)");
}

std::string ExportLabels(const Source& source, const ExportRequest& request, Progress& progress) {
  const std::string path =
      In(request.output, source.deformed ? "segmentation_final.seg.nrrd" : "segmentation.seg.nrrd");
  std::optional<LabelMap> planned;
  if (!source.segmentation.empty()) planned = ReadLabelMap(source.segmentation);
  if (source.deformed || !planned) {
    Points positions;
    const TetMesh mesh = ReadTetMesh(source.tetra_file, &positions);
    WriteSegmentation(path, DeformedLabels(mesh, positions, planned, progress));
  } else {
    WriteSegmentation(path, *planned);
  }
  if (request.ras) RewriteAsRas(path);
  return path;
}

}  // namespace

std::vector<std::string> Export(const ExportRequest& request, Progress& progress) {
  CheckFormat(request.format);
  const Source source = OpenSource(request.input);
  const Space space = request.ras ? Space::RAS : Space::LPS;
  std::error_code error;
  fs::create_directories(request.output, error);
  if (error || !fs::is_directory(request.output))
    throw InputError(request.output, "", "cannot be made a folder");
  if (request.format == "seg.nrrd") return {ExportLabels(source, request, progress)};

  std::vector<std::string> written;
  const auto target = [&](const std::string& name) {
    written.push_back(In(request.output, name + "." + request.format));
    progress.ThrowIfCancelled();
    progress.Report(0.5, "writing " + written.back());
    return written.back();
  };
  const bool has_organ_surface = !source.deformed && !source.surfaces.empty() &&
                                 source.surfaces.front().first == source.tetra_name;
  if (request.format == "vtu" || !has_organ_surface) {
    Points positions;
    const TetMesh mesh = ReadTetMesh(source.tetra_file, &positions);
    if (request.format == "vtu") {
      WriteTetMesh(mesh, positions, target(source.tetra_name), space);
      return written;
    }
    std::vector<Index> vertex;
    const SurfaceMesh surface = BoundarySurface(mesh, positions, &vertex);
    Points rest(static_cast<Index>(vertex.size()), 3);
    for (std::size_t i = 0; i < vertex.size(); ++i) rest.row(i) = mesh.rest.row(vertex[i]);
    WriteSurface(surface, target(source.tetra_name), space, &rest);
  }
  for (const auto& [name, file] : source.surfaces) {
    SurfaceFile surface;
    try {
      surface = ReadSurfaceFile(file);
    } catch (const InputError& e) {
      // A structure of which nothing is left is an empty file, and no reason to fail.
      if (e.Element() != "points" && e.Element() != "triangles") throw;
      progress.Warn(file + " holds no triangles: left out");
      continue;
    }
    WriteSurface(surface.surface, target(name), space,
                 surface.rest_position ? &*surface.rest_position : nullptr);
  }
  return written;
}

}  // namespace kerf
