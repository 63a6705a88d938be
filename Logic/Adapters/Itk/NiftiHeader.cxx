#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "Adapters/Itk/RawHeader.h"
#include "Core/Errors.h"
#include "Core/Types.h"

namespace kerf {
namespace {

/// gzip or plain bytes: zlib reads both.
class Bytes {
 public:
  explicit Bytes(const std::string& path) : file_(gzopen(path.c_str(), "rb")) {
    if (!file_) throw InputError(path, "", "cannot be opened");
  }
  ~Bytes() { gzclose(file_); }
  Bytes(const Bytes&) = delete;
  Bytes& operator=(const Bytes&) = delete;
  /// @return bytes read; fewer at the end or at damaged compression
  std::size_t Read(char* out, std::size_t count) {
    std::size_t done = 0;
    while (done < count) {
      const int n =
          gzread(file_, out + done,
                 static_cast<unsigned>(std::min<std::size_t>(count - done, std::size_t(1) << 24)));
      if (n <= 0) break;
      done += static_cast<std::size_t>(n);
    }
    return done;
  }

 private:
  gzFile file_;
};

/// The fields of NIfTI-1 and NIfTI-2 that decide where voxels lie.
struct Header {
  std::int64_t dim[8] = {};
  double pixdim[8] = {};
  int datatype = 0, bits = 0, qform = 0, sform = 0;
  double vox_offset = 0, slope = 0, intercept = 0;
  double quatern[3] = {}, qoffset[3] = {}, srow[3][4] = {};
};

class Fields {
 public:
  Fields(const char* bytes, bool swap) : bytes_(bytes), swap_(swap) {}
  template <class T>
  T Get(std::size_t offset) const {
    char raw[sizeof(T)];
    std::memcpy(raw, bytes_ + offset, sizeof(T));
    if (swap_) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

 private:
  const char* bytes_;
  bool swap_;
};

Header ReadNifti1(const Fields& f) {
  Header h;
  for (int i = 0; i < 8; ++i) h.dim[i] = f.Get<std::int16_t>(40 + 2 * i);
  for (int i = 0; i < 8; ++i) h.pixdim[i] = f.Get<float>(76 + 4 * i);
  h.datatype = f.Get<std::int16_t>(70);
  h.bits = f.Get<std::int16_t>(72);
  h.vox_offset = f.Get<float>(108);
  h.slope = f.Get<float>(112);
  h.intercept = f.Get<float>(116);
  h.qform = f.Get<std::int16_t>(252);
  h.sform = f.Get<std::int16_t>(254);
  for (int i = 0; i < 3; ++i) h.quatern[i] = f.Get<float>(256 + 4 * i);
  for (int i = 0; i < 3; ++i) h.qoffset[i] = f.Get<float>(268 + 4 * i);
  for (int i = 0; i < 12; ++i) h.srow[i / 4][i % 4] = f.Get<float>(280 + 4 * i);
  return h;
}

Header ReadNifti2(const Fields& f) {
  Header h;
  h.datatype = f.Get<std::int16_t>(12);
  h.bits = f.Get<std::int16_t>(14);
  for (int i = 0; i < 8; ++i) h.dim[i] = f.Get<std::int64_t>(16 + 8 * i);
  for (int i = 0; i < 8; ++i) h.pixdim[i] = f.Get<double>(104 + 8 * i);
  h.vox_offset = double(f.Get<std::int64_t>(168));
  h.slope = f.Get<double>(176);
  h.intercept = f.Get<double>(184);
  h.qform = f.Get<std::int32_t>(344);
  h.sform = f.Get<std::int32_t>(348);
  for (int i = 0; i < 3; ++i) h.quatern[i] = f.Get<double>(352 + 8 * i);
  for (int i = 0; i < 3; ++i) h.qoffset[i] = f.Get<double>(376 + 8 * i);
  for (int i = 0; i < 12; ++i) h.srow[i / 4][i % 4] = f.Get<double>(400 + 8 * i);
  return h;
}

Mat3 RotationOf(const Header& h) {
  const double b = h.quatern[0], c = h.quatern[1], d = h.quatern[2];
  const double a = std::sqrt(std::max(0.0, 1 - b * b - c * c - d * d));
  Mat3 rotation = Eigen::Quaterniond(a, b, c, d).toRotationMatrix();
  if (h.pixdim[0] < 0) rotation.col(2) *= -1;
  return rotation;
}

void CheckAxes(const std::string& path, const Header& h, Progress& progress) {
  if (h.sform <= 0 && h.qform <= 0) {
    progress.Warn(path +
                  ": neither qform nor sform: left and right, front and back are assumed to follow "
                  "the voxel axes (RAS)");
    return;
  }
  Mat3 axes = Mat3::Identity();
  if (h.sform > 0) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) axes(r, c) = h.srow[r][c];
    if (!axes.allFinite()) throw InputError(path, "sform (srow_x, srow_y, srow_z)", "not a number");
    for (int c = 0; c < 3; ++c) {
      const double length = axes.col(c).norm();
      if (length < 1e-6)
        throw InputError(path, "sform (srow_x, srow_y, srow_z)", "an axis has zero length");
      if (std::abs(length - h.pixdim[c + 1]) > 0.01 * h.pixdim[c + 1])
        throw InputError(
            path, fmt::format("pixdim[{}] and sform", c + 1),
            fmt::format("contradict each other: {} and {:.4f} mm", h.pixdim[c + 1], length));
      axes.col(c) /= length;
    }
    const Mat3 gram = axes.transpose() * axes;
    if ((gram - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-2)
      throw InputError(path, "sform (srow_x, srow_y, srow_z)",
                       "axes are sheared; resample to an orthogonal grid first");
  }
  if (h.qform > 0) {
    for (double q : h.quatern)
      if (!std::isfinite(q)) throw InputError(path, "qform (quatern_b, c, d)", "not a number");
    const Mat3 rotation = RotationOf(h);
    if (h.sform > 0 && (rotation - axes).cwiseAbs().maxCoeff() > 0.02)
      progress.Warn(path + ": qform and sform give different orientations; the sform was taken");
  }
}

}  // namespace

void CheckNiftiHeader(const std::string& path, Progress& progress) {
  Bytes file(path);
  std::vector<char> raw(540);
  const std::size_t got = file.Read(raw.data(), raw.size());
  if (got < 352) throw InputError(path, "header", "truncated: no NIfTI header of 348 bytes");
  Header h;
  std::size_t header_size = 0;
  for (const bool swap : {false, true}) {
    const Fields fields(raw.data(), swap);
    const auto size = fields.Get<std::int32_t>(0);
    if (size == 348) h = ReadNifti1(fields);
    if (size == 540 && got == 540) h = ReadNifti2(fields);
    if (size == 348 || size == 540) header_size = static_cast<std::size_t>(size);
  }
  if (header_size == 0) throw InputError(path, "sizeof_hdr", "not a NIfTI file");
  // An Analyze file has the same header but no orientation: left and right would be guessed.
  const std::size_t magic = header_size == 348 ? 344 : 4;
  if (std::string(raw.data() + magic, 3) != (header_size == 348 ? "n+1" : "n+2"))
    throw InputError(path, "magic", "not that of a NIfTI file in one piece (Analyze?)");

  if (h.dim[0] < 1 || h.dim[0] > 7) throw InputError(path, "dim[0]", "must be 1 to 7");
  if (h.dim[0] < 3)
    throw InputError(path, "dim[0]", fmt::format("a {}-D image is no volume", h.dim[0]));
  for (int a = 1; a <= 3; ++a) {
    if (h.dim[a] <= 0)
      throw InputError(path, fmt::format("dim[{}]", a), fmt::format("{} voxels", h.dim[a]));
    if (h.dim[a] == 1)
      throw InputError(path, fmt::format("dim[{}]", a), "one voxel: a 2-D image is no volume");
  }
  for (int a = 4; a <= h.dim[0]; ++a)
    if (h.dim[a] > 1)
      throw InputError(path, fmt::format("dim[{}]", a),
                       fmt::format("{} volumes in one file (4-D); extract one first", h.dim[a]));
  for (int a = 1; a <= 3; ++a) {
    const double spacing = h.pixdim[a];
    if (!std::isfinite(spacing))
      throw InputError(path, fmt::format("pixdim[{}]", a), "the spacing is not a number");
    if (spacing <= 0)
      throw InputError(path, fmt::format("pixdim[{}]", a),
                       fmt::format("the spacing {} must be positive", spacing));
  }
  if (h.datatype == 128 || h.datatype == 2304)
    throw InputError(path, "datatype", "a colour image is no CT");
  if (h.datatype == 32 || h.datatype == 1792 || h.datatype == 2048)
    throw InputError(path, "datatype", "complex values are no CT");
  for (const double q : h.qoffset)
    if (h.qform > 0 && !std::isfinite(q)) throw InputError(path, "qoffset", "not a number");
  if (!std::isfinite(h.slope) || !std::isfinite(h.intercept))
    throw InputError(path, "scl_slope, scl_inter", "not a number");
  CheckAxes(path, h, progress);

  // The voxels of a pair .hdr/.img are in the other file, whose length ITK checks.
  if (path.size() > 4 && path.compare(path.size() - 4, 4, ".hdr") == 0) return;
  const double voxels = double(h.dim[1]) * double(h.dim[2]) * double(h.dim[3]);
  const double needed = std::max(h.vox_offset, double(header_size)) + voxels * h.bits / 8;
  std::vector<char> buffer(std::size_t(1) << 20);
  double have = double(got);
  while (have < needed) {
    progress.ThrowIfCancelled();
    const std::size_t n = file.Read(buffer.data(), buffer.size());
    if (n == 0)
      throw InputError(path, "voxel data",
                       fmt::format("truncated: {:.0f} of {:.0f} bytes", have, needed));
    have += double(n);
  }
}

}  // namespace kerf
