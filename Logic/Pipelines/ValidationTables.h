#pragma once
// Private to Pipelines: the tables of a validation, ours beside the paper's.

#include <string>
#include <vector>

#include "Pipelines/ValidatePipeline.h"

namespace kerf {

struct ValidationTable {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// As Table 1 of the paper: Dice without and with cutting, at the last frame. One table per method
/// and input.
std::vector<ValidationTable> DiceTables(const std::vector<ValidationRun>& runs);
/// As Table 2: feature error, organ and inner structure distances, average and largest, without and
/// with cutting.
std::vector<ValidationTable> DistanceTables(const std::vector<ValidationRun>& runs);
/// Cuts in time and place, missed and false ones, and the time a frame takes.
ValidationTable CutTable(const std::vector<ValidationRun>& runs);

std::string Markdown(const ValidationTable& table);

}  // namespace kerf
