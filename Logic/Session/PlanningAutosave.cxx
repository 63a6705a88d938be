#include "Session/PlanningAutosave.h"

#include <cstring>
#include <fstream>

#include "CaseIO/AtomicFile.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr char kMagic[] = "kerf-work 1\n";

/// Little writer and reader of plain values; files of one machine, never exchanged.
class Writer {
 public:
  explicit Writer(std::ostream& stream) : stream_(stream) {}
  template <class T>
  void Value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    stream_.write(reinterpret_cast<const char*>(&v), sizeof v);
  }
  void Text(const std::string& text) {
    Value<std::uint64_t>(text.size());
    stream_.write(text.data(), static_cast<std::streamsize>(text.size()));
  }
  void Doubles(const double* data, std::size_t n) {
    stream_.write(reinterpret_cast<const char*>(data),
                  static_cast<std::streamsize>(n * sizeof(double)));
  }
  void Vector(const Vec3& v) { Doubles(v.data(), 3); }

 private:
  std::ostream& stream_;
};

class Reader {
 public:
  Reader(std::istream& stream, const std::string& file) : stream_(stream), file_(file) {}
  void Bytes(void* to, std::size_t n, const char* element) {
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(n));
    if (!stream_) throw InputError(file_, element, "the file ends too early");
  }
  template <class T>
  T Value(const char* element) {
    T v;
    Bytes(&v, sizeof v, element);
    return v;
  }
  std::uint64_t Count(std::uint64_t most, const char* element) {
    const auto n = Value<std::uint64_t>(element);
    if (n > most) throw InputError(file_, element, "a size that cannot be");
    return n;
  }
  std::string Text(const char* element) {
    std::string text(Count(1u << 20, element), '\0');
    Bytes(text.data(), text.size(), element);
    return text;
  }
  Vec3 Vector(const char* element) {
    Vec3 v;
    Bytes(v.data(), 3 * sizeof(double), element);
    return v;
  }

 private:
  std::istream& stream_;
  const std::string& file_;
};

void CheckHeader(Reader& in, const std::string& file) {
  char magic[sizeof kMagic - 1];
  in.Bytes(magic, sizeof magic, "header");
  if (std::memcmp(magic, kMagic, sizeof magic) != 0)
    throw InputError(file, "header", "it was written by another version of Kerf");
}

void WritePoints(Writer& out, const std::vector<MarkupPoint>& points) {
  out.Value<std::uint64_t>(points.size());
  for (const MarkupPoint& p : points) {
    out.Text(p.label);
    out.Vector(p.position_mm);
  }
}

std::vector<MarkupPoint> ReadPoints(Reader& in, const char* element) {
  std::vector<MarkupPoint> points(in.Count(100000, element));
  for (MarkupPoint& p : points) {
    p.label = in.Text(element);
    p.position_mm = in.Vector(element);
  }
  return points;
}

void WriteLabels(Writer& out, const LabelMap& labels) {
  out.Value(labels.grid.size[0]);
  out.Value(labels.grid.size[1]);
  out.Value(labels.grid.size[2]);
  out.Vector(labels.grid.spacing_mm);
  out.Vector(labels.grid.origin_mm);
  out.Doubles(labels.grid.direction.data(), 9);
  const auto& v = *labels.voxels;
  for (std::size_t i = 0; i < v.size();) {
    std::size_t end = i + 1;
    while (end < v.size() && v[end] == v[i] && end - i < 0xffffffffu) ++end;
    out.Value(v[i]);
    out.Value(static_cast<std::uint32_t>(end - i));
    i = end;
  }
}

LabelMap ReadLabels(Reader& in, const std::string& file) {
  LabelMap labels;
  for (int a = 0; a < 3; ++a) labels.grid.size[a] = in.Value<int>("grid");
  labels.grid.spacing_mm = in.Vector("grid");
  labels.grid.origin_mm = in.Vector("grid");
  in.Bytes(labels.grid.direction.data(), 9 * sizeof(double), "grid");
  labels.grid.Validate(file);
  if (labels.grid.VoxelCount() > (std::size_t(1) << 33))
    throw InputError(file, "grid", "a size that cannot be");
  labels.source = file;
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount());
  for (std::size_t at = 0; at < voxels->size();) {
    const auto value = in.Value<std::uint8_t>("labels");
    const auto length = in.Value<std::uint32_t>("labels");
    if (length == 0 || length > voxels->size() - at)
      throw InputError(file, "labels", "runs do not fill the volume");
    std::memset(voxels->data() + at, value, length);
    at += length;
  }
  labels.voxels = std::move(voxels);
  return labels;
}

}  // namespace

PlanningWork TakeWork(const PlanningSession& session) {
  PlanningWork work;
  work.ct_path = session.CtPath();
  work.series = session.Series();
  work.labels = session.Labels().Snapshot();
  work.rest.seeds = session.Seeds();
  work.rest.landmarks = session.Landmarks();
  work.rest.plan = session.Plan();
  work.rest.camera = session.Camera();
  work.rest.camera_path = session.CameraPath();
  work.rest.folder = session.CaseFolderPath();
  return work;
}

void SaveWork(const PlanningWork& work, const std::string& file) {
  AtomicFile atomic(file);
  Writer out(atomic.Stream());
  atomic.Stream() << kMagic;
  out.Text(work.ct_path);
  out.Text(work.series);
  out.Text(work.rest.folder);
  WritePoints(out, work.rest.seeds);
  WritePoints(out, work.rest.landmarks);
  const ResectionPlan& plan = work.rest.plan;
  out.Value(plan.margin_mm);
  out.Value(plan.depth_mm);
  out.Vector(plan.direction);
  out.Value<char>(plan.follows_surface);
  out.Value<std::uint64_t>(plan.line.rows());
  out.Doubles(plan.line.data(), static_cast<std::size_t>(plan.line.size()));
  out.Text(work.rest.camera_path);
  out.Value<char>(work.rest.camera.has_value());
  if (work.rest.camera) {
    const CameraModel& c = *work.rest.camera;
    for (const double v : {double(c.width), double(c.height), c.fx, c.fy, c.cx, c.cy}) out.Value(v);
    out.Doubles(c.distortion.data(), 5);
    out.Doubles(c.camera_from_world.matrix().data(), 16);
  }
  WriteLabels(out, work.labels);
  atomic.Commit();
}

std::string CtOfWork(const std::string& file) {
  try {
    std::ifstream stream(file, std::ios::binary);
    Reader in(stream, file);
    CheckHeader(in, file);
    return in.Text("CT");
  } catch (const InputError&) {
    return {};
  }
}

PlanningWork LoadWork(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file, "", "cannot be opened");
  Reader in(stream, file);
  CheckHeader(in, file);
  PlanningWork work;
  work.ct_path = in.Text("CT");
  work.series = in.Text("series");
  work.rest.folder = in.Text("folder");
  work.rest.seeds = ReadPoints(in, "seeds");
  work.rest.landmarks = ReadPoints(in, "landmarks");
  ResectionPlan& plan = work.rest.plan;
  plan.margin_mm = in.Value<double>("plan");
  plan.depth_mm = in.Value<double>("plan");
  plan.direction = in.Vector("plan");
  plan.follows_surface = in.Value<char>("plan") != 0;
  plan.line.resize(static_cast<Eigen::Index>(in.Count(100000, "plan")), 3);
  in.Bytes(plan.line.data(), static_cast<std::size_t>(plan.line.size()) * sizeof(double), "plan");
  work.rest.camera_path = in.Text("camera");
  if (in.Value<char>("camera")) {
    CameraModel c;
    c.width = static_cast<int>(in.Value<double>("camera"));
    c.height = static_cast<int>(in.Value<double>("camera"));
    for (double* v : {&c.fx, &c.fy, &c.cx, &c.cy}) *v = in.Value<double>("camera");
    in.Bytes(c.distortion.data(), 5 * sizeof(double), "camera");
    in.Bytes(c.camera_from_world.matrix().data(), 16 * sizeof(double), "camera");
    work.rest.camera = c;
  }
  work.labels = ReadLabels(in, file);
  return work;
}

}  // namespace kerf
