#pragma once

#include <optional>
#include <string>
#include <vector>

#include "CaseIO/ResultsFiles.h"

namespace kerf {

/// One line of a journal.
struct JournalEntry {
  double time_s = 0.0;
  int frame = 0;
  std::string event;
  JournalData data;

  /// Value of a key, null where there is none or it is of another type. Whole numbers answer to
  /// double too.
  const std::string* Text(const std::string& key) const;
  std::optional<double> Number(const std::string& key) const;
  std::vector<double> Numbers(const std::string& key) const;
};

/// Reads journal.jsonl. A last line without its end is left out: what a crash was about to say.
/// @throws InputError naming file and line
std::vector<JournalEntry> ReadJournal(const std::string& path);

}  // namespace kerf
