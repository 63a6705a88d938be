#pragma once

#include <cstdint>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "CaseIO/Csv.h"
#include "CaseIO/Space.h"
#include "Core/Features.h"
#include "Core/Types.h"

namespace kerf {

/// "frame_%05d_organ.vtp" and the like. @param what "organ", "internal", "tumour"; @param extension
/// without the dot
std::string FrameFileName(int frame, const std::string& what, const std::string& extension);

/// features.csv: frame,id,x_mm,y_mm,z_mm,x0_mm,y0_mm,z0_mm,state; every feature of every written
/// frame. LPS.
class FeaturesFile {
 public:
  explicit FeaturesFile(const std::string& path);
  /// @param current, rest N×3, LPS mm; same rows as `features`
  void Add(int frame, const FeatureSet& features, const Points& current, const Points& rest);
  void Finish() { csv_.Finish(); }

 private:
  CsvWriter csv_;
};

/// One entry of cuts.json: a cut that was applied.
struct CutRecord {
  int detected_frame = 0;
  Points polyline_rest;  ///< N×3 on the rest surface, LPS mm
  double depth_mm = 0.0;
  double confidence = 0.0;  ///< 0..1
};
/// cuts.json, tagged LPS; an empty list where cutting was off.
void WriteCutsFile(const std::string& path, const std::vector<CutRecord>& cuts);
/// detected_frame of a cut whose file does not tell one.
constexpr int kNoFrame = std::numeric_limits<int>::max();
/// Either space; converted to LPS. @param space the space of the file, may be null
/// @throws InputError naming file and cut
std::vector<CutRecord> ReadCutsFile(const std::string& path, Space* space = nullptr);

/// One line of reliability.csv: frame,time_s,state,score,reason,tumour_u95_mm.
struct ReliabilityRow {
  int frame = 0;
  double time_s = 0.0;
  std::string state = "off";  ///< green, amber, off
  double score = 0.0;         ///< 0..1
  std::string reason;
  double tumour_u95_mm = 0.0;  ///< NaN (an empty field) where the organ has no tumour
};
void WriteReliabilityFile(const std::string& path, const std::vector<ReliabilityRow>& rows);
std::vector<ReliabilityRow> ReadReliabilityFile(const std::string& path);

/// One line of timing.csv, milliseconds.
struct TimingRow {
  int frame = 0;
  double capture_ms = 0, tracking_ms = 0, targets_ms = 0, detection_ms = 0, cutting_ms = 0,
         solve_ms = 0, structures_ms = 0, render_ms = 0, total_ms = 0;
};
void WriteTimingFile(const std::string& path, const std::vector<TimingRow>& rows);
std::vector<TimingRow> ReadTimingFile(const std::string& path);

/// A value in a journal entry's data.
struct JournalValue {
  JournalValue(bool v) : value(v) {}
  JournalValue(int v) : value(std::int64_t(v)) {}
  JournalValue(std::int64_t v) : value(v) {}
  JournalValue(double v) : value(v) {}
  JournalValue(const char* v) : value(std::string(v)) {}
  JournalValue(std::string v) : value(std::move(v)) {}
  JournalValue(std::vector<double> v) : value(std::move(v)) {}
  JournalValue(std::vector<std::string> v) : value(std::move(v)) {}
  std::variant<bool, std::int64_t, double, std::string, std::vector<double>,
               std::vector<std::string>>
      value;
};
using JournalData = std::vector<std::pair<std::string, JournalValue>>;

/// journal.jsonl: append-only, one object a line {"time_s","frame","event","data"}; every line is
/// flushed when written, so that a crash loses nothing that was said. Never a patient's name.
class Journal {
 public:
  /// @param append go on with an existing journal (a session); otherwise it starts anew
  explicit Journal(const std::string& path, bool append = false);
  /// @throws InputError naming the journal when it cannot be written any more
  void Write(double time_s, int frame, const std::string& event, const JournalData& data = {});

 private:
  std::string path_;
  std::ofstream stream_;
};

/// Lower-case hexadecimal SHA-256. @throws InputError naming the file
std::string Sha256OfFile(const std::string& path);
std::string Sha256OfText(const std::string& text);

}  // namespace kerf
