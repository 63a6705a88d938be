#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace kerf {

/// A file of a case: its path relative to the case, its role and its SHA-256.
struct CaseFile {
  std::string path;  ///< relative, with '/', inside the case
  std::string role;  ///< ct, segmentation, organ_mesh, organ_surface, internal, tumour, landmarks,
                     ///< camera, plan…
  std::string sha256;  ///< 64 lower-case hexadecimal digits; empty only in schema 1
  std::uint64_t bytes = 0;
};

/// case.json: the versioned manifest. Schema: docs/reference/case-folder.md.
struct CaseManifest {
  static constexpr int kSchema = 2;  ///< written; 1…kSchema are read, newer ones are refused
  int schema = kSchema;
  std::string pseudonym;  ///< never a patient's name
  std::string space = "LPS", length_unit = "mm";
  std::map<std::string, std::string>
      provenance;               ///< program, version, input file names and SHA-256, parameters
  std::vector<CaseFile> files;  ///< sorted by path
};

/// A pseudonym derived from the hash of the input: the same CT gives the same pseudonym, which
/// tells nothing.
std::string PseudonymFromHash(const std::string& sha256);

/// A case folder that exists. Immutable; reads to paths, the adapters read the files.
class CaseFolder {
 public:
  /// @param verify check presence and SHA-256 of every file
  /// @throws InputError naming file and key: no manifest, a study given, newer schema, missing or
  /// corrupt file
  static CaseFolder Open(const std::string& root, bool verify = true);

  const std::string& Root() const { return root_; }
  const CaseManifest& Manifest() const { return manifest_; }
  bool Has(const std::string& role) const;
  /// Path of the (first) file with this role. @throws InputError naming the role where there is
  /// none
  std::string Path(const std::string& role) const;
  std::vector<std::string> Paths(const std::string& role) const;

 private:
  std::string root_;
  CaseManifest manifest_;
};

/// Builds a case folder beside its final place and swaps it in with one rename: a crash at any
/// moment leaves either the old case or the new one, whole. Sessions recorded in the old case are
/// kept.
class CaseWriter {
 public:
  /// A new case at `root`. An older case there is replaced on Commit().
  /// @throws InputError when the folder cannot be written, UsageError when `root` holds something
  /// that is no case
  explicit CaseWriter(const std::string& root);
  /// Starts from the files of an existing case (hard links), to add or replace some.
  static CaseWriter Update(const std::string& root);
  ~CaseWriter();  ///< without Commit() nothing is left behind
  CaseWriter(CaseWriter&& other) noexcept;
  CaseWriter& operator=(CaseWriter&&) = delete;

  /// Where to write the file `relative` (with its folder made); it enters the manifest with this
  /// role.
  std::string Stage(const std::string& relative, const std::string& role);
  void Remove(const std::string& relative);
  /// Pseudonym and provenance; `files` is filled by Commit().
  CaseManifest& Manifest() { return manifest_; }
  /// Hashes the files, writes the manifest, swaps the folder in. @throws InputError naming a staged
  /// file that is missing
  void Commit();

 private:
  std::string root_, stage_;
  CaseManifest manifest_;
  std::map<std::string, std::string> role_of_;
};

/// "kerf-case", "kerf-study" or "" as the folder's case.json says; "" where there is none or it
/// cannot be read.
std::string FolderFormat(const std::string& root);

}  // namespace kerf
