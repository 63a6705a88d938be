#include "Adapters/Rendering/CoverageMap.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace kerf {

void CoverageMap::Clear(const PixelBox& box) {
  for (int y = box.y0; y < box.y1; ++y)
    if (box.x1 > box.x0) std::memset(Row(y) + box.x0, 0, std::size_t(box.x1 - box.x0));
}

void CoverageMap::Smooth(const PixelBox& box, double gain) {
  if (box.Empty()) return;
  const int w = box.x1 - box.x0, h = box.y1 - box.y0;
  // Horizontal sums of three rows are kept in a ring, so that the map is smoothed in place.
  std::vector<std::uint16_t> ring(std::size_t(3) * w);
  const auto horizontal = [&](int y, std::uint16_t* out) {
    const std::uint8_t* in = Row(y) + box.x0;
    for (int x = 1; x + 1 < w; ++x)
      out[x] = static_cast<std::uint16_t>(in[x - 1] + 2 * in[x] + in[x + 1]);
    out[0] = static_cast<std::uint16_t>(3 * in[0] + in[std::min(1, w - 1)]);
    out[w - 1] = static_cast<std::uint16_t>(3 * in[w - 1] + in[std::max(0, w - 2)]);
  };
  const int factor = static_cast<int>(std::lround(gain * 256.0));
  horizontal(box.y0, ring.data());
  std::memcpy(ring.data() + std::size_t(2) * w, ring.data(), sizeof(std::uint16_t) * w);
  for (int y = 0; y < h; ++y) {
    std::uint16_t* below = ring.data() + std::size_t((y + 1) % 3) * w;
    if (y + 1 < h) {
      horizontal(box.y0 + y + 1, below);
    } else {
      std::memcpy(below, ring.data() + std::size_t(y % 3) * w, sizeof(std::uint16_t) * w);
    }
    const std::uint16_t *here = ring.data() + std::size_t(y % 3) * w,
                        *above = ring.data() + std::size_t((y + 2) % 3) * w;
    std::uint8_t* out = Row(box.y0 + y) + box.x0;
    for (int x = 0; x < w; ++x) {
      const int sum = (above[x] + 2 * here[x] + below[x]) * factor >> 12;
      out[x] = static_cast<std::uint8_t>(std::min(255, sum));
    }
  }
}

PixelBox CoverageMap::DrawSegment(const Vec2& a, const Vec2& b, double width_px, double start_px,
                                  double dash_px) {
  const double half = 0.5 * width_px;
  const auto lower = [&](double v, int limit) {
    return static_cast<int>(std::clamp(std::floor(v - half - 1), 0.0, double(limit)));
  };
  const auto upper = [&](double v, int limit) {
    return static_cast<int>(std::clamp(std::ceil(v + half + 2), 0.0, double(limit)));
  };
  const PixelBox box{lower(std::min(a.x(), b.x()), width_), lower(std::min(a.y(), b.y()), height_),
                     upper(std::max(a.x(), b.x()), width_), upper(std::max(a.y(), b.y()), height_)};
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm(), length = std::sqrt(length2);
  for (int y = box.y0; y < box.y1; ++y) {
    std::uint8_t* row = Row(y);
    for (int x = box.x0; x < box.x1; ++x) {
      const Vec2 p = Vec2(x, y) - a;
      const double t = length2 > 0 ? std::clamp(p.dot(along) / length2, 0.0, 1.0) : 0.0;
      if (dash_px > 0 && std::fmod(start_px + t * length, 2.0 * dash_px) > dash_px) continue;
      const double cover = std::clamp(half + 0.5 - (p - t * along).norm(), 0.0, 1.0);
      row[x] = std::max(row[x], static_cast<std::uint8_t>(std::lround(255.0 * cover)));
    }
  }
  return box;
}

PixelBox CoverageMap::DrawPolyline(const Pixels& pixels, double width_px, double dash_px) {
  PixelBox all;
  double start = 0.0;
  for (Eigen::Index i = 0; i + 1 < pixels.rows(); ++i) {
    const Vec2 a = pixels.row(i).transpose(), b = pixels.row(i + 1).transpose();
    // A lens has no image of points behind it, and far outside nothing is seen.
    if (!a.allFinite() || !b.allFinite() || a.cwiseAbs().maxCoeff() > 1e5 ||
        b.cwiseAbs().maxCoeff() > 1e5)
      continue;
    const PixelBox box = DrawSegment(a, b, width_px, start, dash_px);
    start += (b - a).norm();
    if (box.Empty()) continue;
    all.Include(box.x0, box.y0);
    all.Include(box.x1 - 1, box.y1 - 1);
  }
  return all;
}

PixelBox CoverageMap::DrawDisc(const Vec2& center, double radius_px) {
  if (!center.allFinite()) return {};
  return DrawSegment(center, center, 2.0 * radius_px, 0, 0);
}

PixelBox CoverageMap::DrawCircle(const Vec2& center, double radius_px, double width_px) {
  const int n = 96;
  Pixels ring(n + 1, 2);
  for (int i = 0; i <= n; ++i) {
    const double angle = 2.0 * M_PI * i / n;
    ring.row(i) << center.x() + radius_px * std::cos(angle),
        center.y() + radius_px * std::sin(angle);
  }
  return DrawPolyline(ring, width_px);
}

void CoverageMap::Blend(const PixelBox& box, const Color& color, double opacity, Image* bgr) const {
  const int strength = static_cast<int>(std::lround(std::clamp(opacity, 0.0, 1.0) * 256.0));
  for (int y = box.y0; y < box.y1; ++y) {
    const std::uint8_t* cover = Row(y);
    std::uint8_t* out = bgr->data.data() + std::size_t(3) * (std::size_t(y) * bgr->width);
    for (int x = box.x0; x < box.x1; ++x) {
      if (cover[x] == 0) {  // mostly: lines are thin
        std::uint64_t eight = 0;
        while (x + 8 < box.x1 && (std::memcpy(&eight, cover + x + 1, 8), eight == 0)) x += 8;
        continue;
      }
      const int a = cover[x] * strength / 255;
      for (int k = 0; k < 3; ++k) {
        std::uint8_t& c = out[3 * x + k];
        c = static_cast<std::uint8_t>((c * (256 - a) + color[2 - k] * a) >> 8);
      }
    }
  }
}

namespace {

// One-dimensional squared distance transform (lower envelope of parabolas).
void SquaredDistance(const std::vector<float>& f, int n, std::vector<int>* site,
                     std::vector<float>* from, std::vector<float>* out) {
  auto& v = *site;
  auto& z = *from;
  int k = 0;
  v[0] = 0;
  z[0] = -std::numeric_limits<float>::infinity();
  z[1] = std::numeric_limits<float>::infinity();
  const auto meet = [&](int q, int p) {
    return ((f[q] + float(q) * q) - (f[p] + float(p) * p)) / (2.0f * (q - p));
  };
  for (int q = 1; q < n; ++q) {
    float s = meet(q, v[k]);
    while (s <= z[k]) s = meet(q, v[--k]);
    v[++k] = q;
    z[k] = s;
    z[k + 1] = std::numeric_limits<float>::infinity();
  }
  k = 0;
  for (int q = 0; q < n; ++q) {
    while (z[k + 1] < q) ++k;
    (*out)[q] = float(q - v[k]) * (q - v[k]) + f[v[k]];
  }
}

}  // namespace

std::vector<float> DistanceToMask(const std::vector<std::uint8_t>& mask, int width,
                                  const PixelBox& box) {
  const int w = box.x1 - box.x0, h = box.y1 - box.y0, longest = std::max(w, h);
  std::vector<float> result(std::size_t(std::max(0, w)) * std::max(0, h));
  if (result.empty()) return result;
  std::vector<float> line(longest), out(longest), from(longest + 1);
  std::vector<int> site(longest);
  const float far = 1e8f;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x)
      line[x] = mask[std::size_t(box.y0 + y) * width + box.x0 + x] ? 0.0f : far;
    SquaredDistance(line, w, &site, &from, &out);
    std::copy_n(out.begin(), w, result.begin() + std::size_t(y) * w);
  }
  for (int x = 0; x < w; ++x) {
    for (int y = 0; y < h; ++y) line[y] = result[std::size_t(y) * w + x];
    SquaredDistance(line, h, &site, &from, &out);
    for (int y = 0; y < h; ++y) result[std::size_t(y) * w + x] = std::sqrt(out[y]);
  }
  return result;
}

}  // namespace kerf
