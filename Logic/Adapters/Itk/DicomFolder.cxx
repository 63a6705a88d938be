#include "Adapters/Itk/DicomFolder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "Adapters/Itk/DicomGaps.h"
#include "Adapters/Itk/DicomHeaders.h"
#include "Adapters/Itk/Intensities.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr double kStepTolerance = 0.02;  // of the slice distance; positions are rounded decimals
constexpr int kFewestSlices = 3;

std::string Name(const DicomSlice& slice) {
  return std::filesystem::path(slice.path).filename().string();
}

std::string Describe(const SeriesInfo& info) {
  return fmt::format("{} ({}{}{}, {} slice{})", info.uid, info.modality,
                     info.description.empty() ? "" : " ", info.description, info.slices,
                     info.slices == 1 ? "" : "s");
}

double MedianStep_mm(const DicomSeries& series) {
  const Vec3 normal = series.slices.front().Normal();
  std::vector<double> steps;
  for (std::size_t i = 1; i < series.slices.size(); ++i)
    steps.push_back(normal.dot(series.slices[i].position_mm - series.slices[i - 1].position_mm));
  if (steps.empty()) return series.slices.front().thickness_mm;
  std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
  return steps[steps.size() / 2];
}

SeriesInfo InfoOf(const DicomSeries& series) {
  const DicomSlice& first = series.slices.front();
  return {series.name,
          first.description,
          first.modality,
          static_cast<int>(series.slices.size()),
          Vec3(first.spacing_x_mm, first.spacing_y_mm, MedianStep_mm(series)),
          first.patient,
          first.laterality,
          first.phase};
}

/// A copy of the same image is dropped; two images at one place are two volumes in one series.
void DropCopies(DicomSeries& series, Progress& progress) {
  const Vec3 normal = series.slices.front().Normal();
  std::vector<DicomSlice> kept;
  for (DicomSlice& slice : series.slices) {
    if (!kept.empty() && std::abs(normal.dot(slice.position_mm - kept.back().position_mm)) < 1e-3) {
      if (!slice.sop_uid.empty() && slice.sop_uid == kept.back().sop_uid) {
        progress.Warn(slice.path + ": the same image as " + Name(kept.back()) + ", ignored");
        continue;
      }
      throw InputError(slice.path, "ImagePositionPatient (0020,0032)",
                       "another slice lies at the same place: " + Name(kept.back()) +
                           " (several phases in one series?)");
    }
    kept.push_back(std::move(slice));
  }
  series.slices = std::move(kept);
}

void CheckOnePatient(const std::vector<const DicomSlice*>& slices) {
  for (const DicomSlice* slice : slices)
    if (slice->patient_key != slices.front()->patient_key)
      throw InputError(
          slice->path, "PatientID (0010,0020), PatientName, PatientBirthDate",
          "another patient than in " + Name(*slices.front()) + ": two patients in one folder");
}

/// @return distance between slices, mm
double CheckStack(const DicomSeries& series, Progress& progress) {
  const auto& slices = series.slices;
  const DicomSlice& first = slices.front();
  const Vec3 normal = first.Normal();
  const double step = MedianStep_mm(series);
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const double here = normal.dot(slices[i].position_mm - slices[i - 1].position_mm);
    const double before = normal.dot(slices[i - 1].position_mm);
    if (std::abs(here - step) <= std::max(0.02, kStepTolerance * step)) continue;
    const double missing = here / step - 1;
    if (missing > 0.5)
      throw InputError(slices[i].path, "ImagePositionPatient (0020,0032)",
                       fmt::format("{} slice(s) missing before it: the step from {} is {:.2f} mm, "
                                   "elsewhere {:.2f} mm (positions {:.2f} and {:.2f} mm)",
                                   std::lround(missing), Name(slices[i - 1]), here, step, before,
                                   before + here));
    throw InputError(slices[i].path, "ImagePositionPatient (0020,0032)",
                     fmt::format("uneven slices: {:.3f} mm after {}, elsewhere {:.3f} mm", here,
                                 Name(slices[i - 1]), step));
  }
  const Vec3 way = slices.back().position_mm - first.position_mm;
  const double shear_mm = (way - normal * normal.dot(way)).norm();
  if (shear_mm > 0.5 * std::min(first.spacing_x_mm, first.spacing_y_mm))
    throw InputError(
        first.path, "GantryDetectorTilt (0018,1120)",
        fmt::format("the gantry was tilted by {:.1f}°: slices are shifted against each other by "
                    "{:.1f} mm in all; resample the series to an upright grid first",
                    std::atan2(shear_mm, normal.dot(way)) * 180 / M_PI, shear_mm));
  if (std::abs(first.tilt_deg) > 0.1)
    progress.Warn(
        fmt::format("{}: the header tells a gantry tilt of {:.1f}°, the slices are not "
                    "shifted: their positions were trusted",
                    first.path, first.tilt_deg));
  if (first.thickness_mm > 0 && std::abs(first.thickness_mm - step) > 0.01 * step + 0.005)
    progress.Warn(
        fmt::format("{}: slice thickness {:.2f} mm ≠ slice distance {:.2f} mm ({}); the "
                    "distance of the positions was taken",
                    first.path, first.thickness_mm, step,
                    first.thickness_mm > step ? "slices overlap" : "gaps between them"));
  return step;
}

std::string SeriesTable(const std::vector<DicomSeries>& all) {
  std::string text;
  for (const DicomSeries& s : all) text += "\n  " + Describe(InfoOf(s));
  return text;
}

DicomSeries Choose(const std::string& folder, const std::vector<DicomSeries>& all,
                   const std::string& wanted, Progress& progress) {
  if (!wanted.empty()) {
    for (const DicomSeries& series : all)
      if (series.name == wanted) return series;
    throw UsageError("no series '" + wanted + "' in " + folder + "; there are:" + SeriesTable(all));
  }
  std::vector<const DicomSeries*> volumes;
  for (const DicomSeries& series : all)
    if (static_cast<int>(series.slices.size()) >= kFewestSlices) volumes.push_back(&series);
  if (volumes.size() > 1)
    throw InputError(folder, "SeriesInstanceUID (0020,000e)",
                     "several series, choose one with --series:" + SeriesTable(all));
  if (volumes.empty()) {
    const DicomSeries& largest = all.front();
    throw InputError(largest.slices.front().path, "series " + largest.name,
                     fmt::format("{} slice(s) make no volume{}", largest.slices.size(),
                                 all.size() > 1 ? "; the folder holds:" + SeriesTable(all) : ""));
  }
  for (const DicomSeries& series : all)
    if (&series != volumes.front())
      progress.Warn(folder + ": left out " + Describe(InfoOf(series)));
  return *volumes.front();
}

}  // namespace

std::vector<SeriesInfo> ListSeries(const std::string& folder, Progress& progress) {
  std::vector<SeriesInfo> result;
  for (const DicomSeries& series : ScanDicomFolder(folder, progress))
    result.push_back(InfoOf(series));
  return result;
}

Volume ReadDicomFolder(const std::string& folder, const std::string& wanted, Progress& progress) {
  SubProgress scanning(progress, 0, 0.3);
  const std::vector<DicomSeries> all = ScanDicomFolder(folder, scanning);
  if (wanted.empty()) {
    std::vector<const DicomSlice*> everyone;
    for (const DicomSeries& series : all)
      for (const DicomSlice& slice : series.slices) everyone.push_back(&slice);
    CheckOnePatient(everyone);
  }
  DicomSeries series = Choose(folder, all, wanted, progress);
  std::vector<const DicomSlice*> chosen;
  for (const DicomSlice& slice : series.slices) chosen.push_back(&slice);
  CheckOnePatient(chosen);
  DropCopies(series, progress);
  if (static_cast<int>(series.slices.size()) < kFewestSlices)
    throw InputError(series.slices.front().path, "series " + series.name,
                     fmt::format("{} slice(s) make no volume", series.slices.size()));
  const double step = CheckStack(series, progress);
  WarnOfMissingSlices(series, all, progress);

  const DicomSlice& first = series.slices.front();
  if (!first.modality.empty() && first.modality != "CT")
    progress.Warn(first.path + ": modality " + first.modality +
                  ", not CT: values are taken as Hounsfield units");
  Volume volume;
  volume.source = folder;
  volume.grid.size = Eigen::Vector3i(first.columns, first.rows, int(series.slices.size()));
  volume.grid.spacing_mm = Vec3(first.spacing_x_mm, first.spacing_y_mm, step);
  volume.grid.origin_mm = first.position_mm;
  const Vec3 row = first.row_axis.normalized();
  const Vec3 normal = row.cross(first.column_axis).normalized();
  volume.grid.direction.col(0) = row;
  volume.grid.direction.col(1) = normal.cross(row);
  volume.grid.direction.col(2) = normal;
  volume.grid.Validate(folder);

  HounsfieldBuilder voxels(folder, volume.grid);
  for (std::size_t k = 0; k < series.slices.size(); ++k) {
    progress.ThrowIfCancelled();
    progress.Report(0.3 + 0.7 * double(k) / series.slices.size(), "reading slices");
    voxels.Append(ReadDicomPixels(series.slices[k]));
  }
  volume.voxels = voxels.Finish(progress);
  volume.metadata["modality"] = first.modality.empty() ? "CT" : first.modality;
  volume.metadata["series"] = series.name;
  volume.metadata["description"] = first.description;
  if (!first.study_uid.empty()) volume.metadata["study"] = first.study_uid;
  if (!first.frame_uid.empty()) volume.metadata["frame_of_reference"] = first.frame_uid;
  return volume;
}

}  // namespace kerf
