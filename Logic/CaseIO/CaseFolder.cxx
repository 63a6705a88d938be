#include "CaseIO/CaseFolder.h"

#include <algorithm>
#include <filesystem>

#include "CaseIO/JsonRead.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

using json_read::Find;
using json_read::Integer;
using json_read::Json;
using json_read::Text;

/// Schema 1 named files without a role: it followed from the fixed names.
std::string RoleOfName(const std::string& path) {
  static const std::map<std::string, std::string> roles = {
      {"ct.nrrd", "ct"},
      {"ct.nii.gz", "ct"},
      {"organ.vtu", "organ_mesh"},
      {"organ.vtp", "organ_surface"},
      {"internal.vtp", "internal"},
      {"tumour.vtp", "tumour"},
      {"camera.yml", "camera"},
      {"segmentation.seg.nrrd", "segmentation"},
      {"landmarks.mrk.json", "landmarks"}};
  if (const auto it = roles.find(path); it != roles.end()) return it->second;
  return path.rfind("plan/", 0) == 0 ? "plan" : "other";
}

CaseFile ReadFileEntry(const Json& entry, int schema, const std::string& file,
                       const std::string& element) {
  CaseFile out;
  if (schema == 1 && entry.is_string()) {
    out.path = entry.get<std::string>();
  } else {
    if (!entry.is_object()) throw InputError(file, element, "is not an object");
    const Json* path = Find(entry, "path");
    if (!path) throw InputError(file, element + ".path", "is missing");
    out.path = Text(*path, file, element + ".path");
    if (auto* v = Find(entry, "role")) out.role = Text(*v, file, element + ".role");
    if (auto* v = Find(entry, "sha256")) out.sha256 = Text(*v, file, element + ".sha256");
    if (auto* v = Find(entry, "bytes"))
      out.bytes = static_cast<std::uint64_t>(json_read::Number(*v, file, element + ".bytes"));
  }
  const fs::path normal = fs::path(out.path).lexically_normal();
  if (out.path.empty() || normal.is_absolute() || *normal.begin() == "..")
    throw InputError(file, element + ".path",
                     "\"" + out.path + "\" does not stay inside the case folder");
  if (out.role.empty()) out.role = RoleOfName(out.path);
  if (out.sha256.empty() && schema > 1) throw InputError(file, element + ".sha256", "is missing");
  return out;
}

CaseManifest ReadManifest(const std::string& file) {
  const Json json = json_read::ReadObject(file);
  const Json* format = Find(json, "format");
  if (!format || *format != "kerf-case")
    throw InputError(file, "format",
                     format && *format == "kerf-study"
                         ? "this is a study (kerf-study), a case folder is expected"
                         : "is not \"kerf-case\": this is no case folder");
  const Json* schema = Find(json, "schema");
  if (!schema) throw InputError(file, "schema", "is missing");
  CaseManifest manifest;
  manifest.schema = Integer(*schema, file, "schema");
  if (manifest.schema > CaseManifest::kSchema)
    throw InputError(file, "schema",
                     "is version " + std::to_string(manifest.schema) +
                         ", this Kerf reads up to version " +
                         std::to_string(CaseManifest::kSchema) + ": update Kerf");
  if (manifest.schema < 1) throw InputError(file, "schema", "is not a known version");
  if (auto* v = Find(json, "pseudonym")) manifest.pseudonym = Text(*v, file, "pseudonym");
  if (auto* units = Find(json, "units"); units && units->is_object()) {
    if (auto* v = Find(*units, "length")) manifest.length_unit = Text(*v, file, "units.length");
    if (manifest.length_unit != "mm") throw InputError(file, "units.length", "is not mm");
  }
  if (auto* v = Find(json, "space")) manifest.space = Text(*v, file, "space");
  if (manifest.space != "LPS") throw InputError(file, "space", "is not LPS");
  if (auto* p = Find(json, "provenance")) {
    if (!p->is_object()) throw InputError(file, "provenance", "is not an object");
    for (const auto& [key, value] : p->items())
      manifest.provenance[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  const Json* files = Find(json, "files");
  if (!files || !files->is_array()) throw InputError(file, "files", "is missing or not a list");
  for (std::size_t i = 0; i < files->size(); ++i)
    manifest.files.push_back(
        ReadFileEntry((*files)[i], manifest.schema, file, "files[" + std::to_string(i) + "]"));
  return manifest;
}

}  // namespace

std::string PseudonymFromHash(const std::string& sha256) { return "case-" + sha256.substr(0, 8); }

std::string FolderFormat(const std::string& root) {
  const fs::path file = fs::path(root) / "case.json";
  if (!fs::is_regular_file(file)) return {};
  try {
    const Json json = json_read::ReadObject(file.string());
    const Json* format = Find(json, "format");
    return format && format->is_string() ? format->get<std::string>() : std::string();
  } catch (const InputError&) {
    return {};
  }
}

CaseFolder CaseFolder::Open(const std::string& root, bool verify) {
  if (!fs::is_directory(root)) throw InputError(root, "", "is no folder");
  const fs::path base(root);
  if (!fs::exists(base / "case.json"))
    throw InputError((base / "case.json").string(), "", "is missing: this is no case folder");
  CaseFolder folder;
  folder.root_ = root;
  folder.manifest_ = ReadManifest((base / "case.json").string());
  if (!verify) return folder;
  for (const auto& file : folder.manifest_.files) {
    const std::string path = (base / file.path).string();
    if (!fs::is_regular_file(path)) throw InputError(path, "", "is missing, case.json lists it");
    if (!file.sha256.empty() && Sha256OfFile(path) != file.sha256)
      throw InputError(path, "SHA-256", "does not match case.json: the file is damaged or changed");
  }
  return folder;
}

bool CaseFolder::Has(const std::string& role) const {
  return std::any_of(manifest_.files.begin(), manifest_.files.end(),
                     [&](const CaseFile& f) { return f.role == role; });
}

std::vector<std::string> CaseFolder::Paths(const std::string& role) const {
  std::vector<std::string> paths;
  for (const auto& file : manifest_.files)
    if (file.role == role) paths.push_back((fs::path(root_) / file.path).string());
  return paths;
}

std::string CaseFolder::Path(const std::string& role) const {
  const auto paths = Paths(role);
  if (paths.empty())
    throw InputError((fs::path(root_) / "case.json").string(), "files",
                     "has no file with the role \"" + role + "\"");
  return paths.front();
}

}  // namespace kerf
