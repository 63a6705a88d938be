#include "Adapters/Itk/DicomGaps.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

namespace kerf {
namespace {

using Slices = std::vector<const DicomSlice*>;

/// Stacks of one series UID are named "UID", "UID#2" ….
std::string SeriesOf(const std::string& name) { return name.substr(0, name.find('#')); }

template <class Keep>
Slices Select(const std::vector<DicomSeries>& all, Keep keep) {
  Slices out;
  for (const DicomSeries& stack : all)
    for (const DicomSlice& slice : stack.slices)
      if (keep(stack, slice)) out.push_back(&slice);
  return out;
}

/// Copies of an image count once.
int CountImages(const Slices& slices) {
  std::set<std::string> images;
  for (const DicomSlice* s : slices) images.insert(s->sop_uid.empty() ? s->path : s->sop_uid);
  return static_cast<int>(images.size());
}

void CheckNumbers(const DicomSeries& series, const Slices& same_series, Progress& progress) {
  for (const DicomSlice& slice : series.slices)
    if (!slice.number) return;
  // Another stack of the series, a localizer say, may hold the lowest number.
  std::map<std::int64_t, const DicomSlice*> by_number;
  for (const DicomSlice* slice : same_series)
    if (slice->number) by_number.emplace(*slice->number, slice);
  const auto& [lowest, lowest_slice] = *by_number.begin();
  if (lowest > 1)
    progress.Warn(fmt::format(
        "{}: InstanceNumber (0020,0013) {} is the lowest of the series: slices before it are "
        "missing, or the scanner counted on from another series; what is here was taken as all",
        lowest_slice->path, lowest));

  const auto& slices = series.slices;
  const auto number = [&](std::size_t i) { return std::int64_t{*slices[i].number}; };
  const std::int64_t step = number(1) - number(0);
  if (std::abs(step) < 2) return;
  for (std::size_t i = 1; i < slices.size(); ++i)
    if (number(i) - number(i - 1) != step) return;
  const DicomSlice& first = step > 0 ? slices.front() : slices.back();
  // Numbers between may belong to another stack of the series. The next slice's is there in any
  // case.
  const auto next = by_number.upper_bound(*first.number);
  if (next->first < *first.number + std::abs(step)) return;
  progress.Warn(
      fmt::format("{}: InstanceNumber (0020,0013) goes on in steps of {}: slices between may have "
                  "been left out; the distance of the positions was taken",
                  first.path, std::abs(step)));
}

void WarnOfCount(const DicomSlice& slice, const char* element, int stated, int here,
                 Progress& progress) {
  progress.Warn(
      fmt::format("{}: {} tells of {} images, {} are here: slices at an end are missing, or are "
                  "those of another reconstruction; what is here was taken as all",
                  slice.path, element, stated, here));
}

}  // namespace

void WarnOfMissingSlices(const DicomSeries& series, const std::vector<DicomSeries>& all,
                         Progress& progress) {
  const std::string name = SeriesOf(series.name);
  const auto of_series = [&](const DicomSeries& stack, const DicomSlice&) {
    return SeriesOf(stack.name) == name;
  };
  const Slices same_series = Select(all, of_series);
  if (series.slices.size() > 1) CheckNumbers(series, same_series, progress);

  const int in_series = CountImages(same_series);
  for (const DicomSlice& slice : series.slices)
    if (slice.images_in_series > in_series) {
      WarnOfCount(slice, "NumberOfSeriesRelatedInstances (0020,1209)", slice.images_in_series,
                  in_series, progress);
      break;
    }
  std::set<std::string> acquisitions;
  for (const DicomSlice& slice : series.slices) {
    if (slice.images_in_acquisition <= 0 || !acquisitions.insert(slice.acquisition).second)
      continue;
    // One acquisition may have been reconstructed into several series of the study.
    const int here = CountImages(Select(all, [&](const DicomSeries&, const DicomSlice& other) {
      return other.study_uid == slice.study_uid && other.acquisition == slice.acquisition;
    }));
    if (slice.images_in_acquisition > here)
      WarnOfCount(slice, "ImagesInAcquisition (0020,1002)", slice.images_in_acquisition, here,
                  progress);
  }
}

}  // namespace kerf
