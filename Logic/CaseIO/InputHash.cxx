#include "CaseIO/InputHash.h"

#include <filesystem>
#include <set>

#include "CaseIO/CaseFolder.h"
#include "CaseIO/ResultsFiles.h"

namespace kerf {

namespace fs = std::filesystem;

std::string Sha256OfInput(const std::string& path, Progress& progress) {
  if (!fs::is_directory(path)) {
    const std::string parent = fs::path(path).parent_path().string();
    if (FolderFormat(parent) == "kerf-case") {
      const CaseManifest manifest = CaseFolder::Open(parent, false).Manifest();
      const auto input = manifest.provenance.find("input_sha256");
      if (input != manifest.provenance.end()) return input->second;
    }
    return Sha256OfFile(path);
  }
  std::set<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.insert(entry.path().string());
  std::string hashes;
  for (const std::string& file : files) {
    progress.ThrowIfCancelled();
    hashes += Sha256OfFile(file);
  }
  return Sha256OfText(hashes);
}

}  // namespace kerf
