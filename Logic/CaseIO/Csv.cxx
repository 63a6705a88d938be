#include "CaseIO/Csv.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <stdexcept>

#include "Core/Errors.h"

namespace kerf {
namespace {

std::string Trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"')
        fields.back() += line[++i];
      else
        quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (auto& field : fields) field = Trimmed(field);
  return fields;
}

}  // namespace

CsvTable CsvTable::Read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be opened");
  CsvTable table;
  table.file_ = path;
  std::string line;
  int number = 0;
  while (std::getline(in, line)) {
    ++number;
    if (number == 1 && line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);
    if (Trimmed(line).empty()) continue;
    auto fields = Split(line);
    if (table.header_.empty()) {
      if (std::set<std::string>(fields.begin(), fields.end()).size() != fields.size())
        throw InputError(path, "header", "names a column twice");
      table.header_ = std::move(fields);
      continue;
    }
    if (fields.size() != table.header_.size())
      throw InputError(path, "line " + std::to_string(number),
                       "has " + std::to_string(fields.size()) + " fields, the header " +
                           std::to_string(table.header_.size()));
    table.lines_.push_back(number);
    for (auto& field : fields) table.fields_.push_back(std::move(field));
  }
  if (table.header_.empty()) throw InputError(path, "header", "the file is empty");
  return table;
}

bool CsvTable::HasColumn(const std::string& name) const {
  for (const auto& column : header_)
    if (column == name) return true;
  return false;
}

int CsvTable::Column(const std::string& name) const {
  for (std::size_t i = 0; i < header_.size(); ++i)
    if (header_[i] == name) return static_cast<int>(i);
  throw InputError(file_, "header", "has no column \"" + name + "\"");
}

const std::string& CsvTable::Text(std::size_t row, int column) const {
  return fields_[row * header_.size() + column];
}

std::string CsvTable::Where(std::size_t row, int column) const {
  return "line " + std::to_string(lines_[row]) + ", column " + header_[column];
}

double CsvTable::Number(std::size_t row, int column) const {
  const std::string& text = Text(row, column);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(file_, Where(row, column), "\"" + text + "\" is not a finite number");
  return value;
}

int CsvTable::Integer(std::size_t row, int column) const {
  const std::string& text = Text(row, column);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(file_, Where(row, column), "\"" + text + "\" is not a whole number");
  return value;
}

CsvWriter::CsvWriter(const std::string& path, const std::vector<std::string>& columns)
    : file_(path), columns_(columns.size()) {
  for (const auto& column : columns) *this << column;
}

void CsvWriter::Next() {
  if (at_ == columns_) at_ = 0;
  if (at_++ > 0) file_.Stream() << ',';
}

CsvWriter& CsvWriter::operator<<(const std::string& text) {
  Next();
  if (text.find_first_of(",\"\n\r") == std::string::npos) {
    file_.Stream() << text;
  } else {
    file_.Stream() << '"';
    for (char c : text) {
      if (c == '"') file_.Stream() << '"';
      file_.Stream() << (c == '\n' || c == '\r' ? ' ' : c);
    }
    file_.Stream() << '"';
  }
  if (at_ == columns_) file_.Stream() << '\n';
  return *this;
}

CsvWriter& CsvWriter::operator<<(int value) { return *this << std::to_string(value); }

CsvWriter& CsvWriter::Fixed(double value, int decimals) {
  if (!std::isfinite(value)) return *this << std::string();
  char buffer[400];
  const auto [end, error] =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  std::string text = error == std::errc() ? std::string(buffer, end) : std::to_string(value);
  // −0.000 and 0.000 are the same number: one spelling.
  if (text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return *this << text;
}

void CsvWriter::Finish() {
  if (at_ != columns_) throw std::logic_error("CsvWriter: incomplete line");
  file_.Commit();
}

}  // namespace kerf
