#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "CaseIO/AtomicFile.h"

namespace kerf {

/// A strict CSV table: one header line, commas, no quoting needed by our files (quoted fields are
/// understood), the same number of fields in every line. Numbers are read independently of the
/// locale.
class CsvTable {
 public:
  /// @throws InputError naming file and line: missing file, empty file, wrong field count, repeated
  /// column
  static CsvTable Read(const std::string& path);

  const std::string& File() const { return file_; }
  std::size_t Rows() const { return lines_.size(); }
  bool HasColumn(const std::string& name) const;
  /// @throws InputError(file, "header") where there is no such column
  int Column(const std::string& name) const;
  const std::string& Text(std::size_t row, int column) const;
  /// Finite number. @throws InputError naming file, line and column
  double Number(std::size_t row, int column) const;
  int Integer(std::size_t row, int column) const;
  /// "line 12, column x_mm": the element of an error message about this field.
  std::string Where(std::size_t row, int column) const;

 private:
  std::string file_;
  std::vector<std::string> header_;
  std::vector<std::string> fields_;  ///< row-major
  std::vector<int> lines_;           ///< line in the file of each row
};

/// Writes a CSV table atomically: the file appears with Finish().
class CsvWriter {
 public:
  CsvWriter(const std::string& path, const std::vector<std::string>& columns);
  CsvWriter& operator<<(const std::string& text);
  CsvWriter& operator<<(const char* text) { return *this << std::string(text); }
  CsvWriter& operator<<(int value);
  /// Fixed-point with `decimals` digits; an empty field where not finite.
  CsvWriter& Fixed(double value, int decimals);
  /// @throws InputError naming the file; std::logic_error on an incomplete line
  void Finish();

 private:
  void Next();
  AtomicFile file_;
  std::size_t columns_, at_ = 0;
};

}  // namespace kerf
