#include "Adapters/Rendering/OverlayCompositor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace kerf {
namespace {

using overlay_colors::kCutFace;
using overlay_colors::kCutLine;
using overlay_colors::kInternal;
using overlay_colors::kOrgan;
using overlay_colors::kPlanned;
using overlay_colors::kTumour;

constexpr float kDepthStep_mm = 2.5f;  // a jump like this within the organ is an edge of it
constexpr float kFade_mm = 60.0f;      // what lies this deep under the surface is a third as strong

void Mix(std::uint8_t* bgr, const Color& color, float shade, float alpha) {
  for (int k = 0; k < 3; ++k)
    bgr[k] = static_cast<std::uint8_t>(
        std::min(255.0f, bgr[k] + alpha * (shade * color[2 - k] - bgr[k]) + 0.5f));
}

/// Where something is in one row of pixels.
struct RowSpan {
  int first = -1, last = -1;
  void Include(int x) {
    if (first < 0) first = x;
    last = x;
  }
  void AddTo(int y, PixelBox* box) const {
    if (first < 0) return;
    box->Include(first, y);
    box->Include(last, y);
  }
};

// The far side of a jump in depth belongs to what is behind: only the near pixel carries the edge.
bool IsDepthEdge(const GeometryBuffer& b, std::size_t i) {
  const float z = b.depth_mm[i];
  const int w = b.width;
  for (const std::size_t step : {std::size_t(1), std::size_t(w)}) {
    const float before = b.depth_mm[i - step], after = b.depth_mm[i + step];
    if (b.surface[i - step] == 0 || b.surface[i + step] == 0) continue;
    // The second difference: a slanting surface has none, a step has.
    if (before + after - 2.0f * z > kDepthStep_mm && std::max(before, after) - z > kDepthStep_mm)
      return true;
  }
  return false;
}

/// Whether eight pixels from `i` on, and all that touch their sides, are of one class: most are.
bool AllAlike(const std::uint8_t* ids, int width) {
  std::uint64_t here, above, below;
  std::memcpy(&here, ids, 8);
  std::memcpy(&above, ids - width, 8);
  std::memcpy(&below, ids + width, 8);
  return here == above && here == below && here == 0x0101010101010101u * ids[0] &&
         ids[-1] == ids[0] && ids[8] == ids[0];
}

}  // namespace

bool OverlayCompositor::InWindow(int x, int y) const {
  const double dx = x - window_.x(), dy = y - window_.y();
  return dx * dx + dy * dy < window_radius_ * window_radius_;
}

void OverlayCompositor::Compose(const CameraModel& camera, const OverlayOptions& options,
                                const OverlayScene& scene, const GeometryBuffer& front,
                                const GeometryBuffer& inside, Image* bgr) {
  box_ = front_box_ = cut_box_ = internal_box_ = tumour_box_ = {};
  nearest_mm_ = std::numeric_limits<float>::max();
  farthest_mm_ = 0;
  PixelBox seen_box = front.box;
  if (!inside.box.Empty()) {
    seen_box.Include(inside.box.x0, inside.box.y0);
    seen_box.Include(inside.box.x1 - 1, inside.box.y1 - 1);
  }
  for (int y = seen_box.y0; y < seen_box.y1; ++y) {
    const std::size_t row = std::size_t(y) * front.width;
    RowSpan outer, cut, internal, tumour;
    for (int x = seen_box.x0; x < seen_box.x1; ++x) {
      const std::uint8_t seen = front.surface[row + x], inner = inside.surface[row + x];
      if (seen != 0) outer.Include(x);
      if (seen == GeometryBuffers::CutFace) cut.Include(x);
      if (inner == 0) continue;
      (inner == GeometryBuffers::Tumour ? tumour : internal).Include(x);
      nearest_mm_ = std::min(nearest_mm_, inside.depth_mm[row + x]);
      farthest_mm_ = std::max(farthest_mm_, inside.depth_mm[row + x]);
    }
    outer.AddTo(y, &front_box_);
    cut.AddTo(y, &cut_box_);
    internal.AddTo(y, &internal_box_);
    tumour.AddTo(y, &tumour_box_);
    for (const RowSpan* span : {&outer, &internal, &tumour}) span->AddTo(y, &box_);
  }
  window_radius_ = 0;
  if (options.preset == OverlayPreset::SeeThrough) {
    window_radius_ = options.window_radius_px > 0 ? options.window_radius_px : 0.25 * front.height;
    window_ = Vec2(0.5 * front.width, 0.5 * front.height);
    if (!tumour_box_.Empty())
      window_ = 0.5 * Vec2(tumour_box_.x0 + tumour_box_.x1, tumour_box_.y0 + tumour_box_.y1);
    if (options.window_px) window_ = *options.window_px;
  }
  const Image raw = scene.instruments ? *bgr : Image{};
  if (!box_.Empty()) {
    PaintSurfaces(options, front, inside, bgr);
    PaintEdges(options, front, inside, bgr);
    PaintMargins(camera, scene, inside, bgr);
    if (window_radius_ > 0)
      Stroke(line_.DrawCircle(window_, window_radius_, 2.0), kOrgan, 0.9, bgr);
  }
  PaintLines(camera, scene, bgr);
  if (options.show_features && scene.features) PaintFeatures(*scene.features, bgr);
  if (scene.instruments) KeepInstruments(*scene.instruments, raw, bgr);
}

void OverlayCompositor::PaintSurfaces(const OverlayOptions& options, const GeometryBuffer& front,
                                      const GeometryBuffer& inside, Image* bgr) const {
  // The rim of a glass body is denser than its middle: the organ reads as a volume and the tissue
  // stays visible.
  float rim[256];
  for (int f = 0; f < 256; ++f) {
    const double away = 1.0 - f / 255.0;
    rim[f] = static_cast<float>(options.organ_opacity * (0.25 + 1.75 * away * away * away));
  }
  const float range = std::max(1.0f, farthest_mm_ - nearest_mm_);
  for (int y = box_.y0; y < box_.y1; ++y)
    for (int x = box_.x0; x < box_.x1; ++x) {
      const std::size_t i = std::size_t(y) * front.width + x;
      const std::uint8_t outer = front.surface[i], inner = inside.surface[i];
      if ((outer | inner) == 0) continue;
      std::uint8_t* out = bgr->data.data() + 3 * i;
      const bool window = window_radius_ > 0 && InWindow(x, y);
      const float below = outer ? inside.depth_mm[i] - front.depth_mm[i] : -1.0f;
      const bool covered = outer && below > 0;

      float wash = 0;
      if (outer == GeometryBuffers::CutFace) {
        wash = 0.7f;
      } else if (outer && options.preset == OverlayPreset::Full) {
        wash = std::min(0.8f, rim[front.facing[i]]);
      }
      // The hole: tissue inside the window steps back, so that what is seen through it stands out.
      if (window && outer == GeometryBuffers::Outer) Mix(out, {10, 14, 24}, 1.0f, 0.55f);
      if (options.preset == OverlayPreset::Outline) wash *= 0.5f;

      // Paint from back to front: the organ first where the structure lies in front of it (seen in
      // an open cut).
      const auto paint_organ = [&](float alpha) {
        if (outer == GeometryBuffers::CutFace) {
          Mix(out, kCutFace, 0.8f + 0.2f * front.facing[i] / 255.0f, alpha);
        } else if (outer) {
          Mix(out, kOrgan, 1.0f, alpha);
        }
      };
      const auto paint_inner = [&] {
        float alpha = static_cast<float>(options.structure_opacity);
        if (options.preset == OverlayPreset::Outline) alpha *= 0.15f;
        if (options.preset == OverlayPreset::SeeThrough && !window) alpha *= 0.15f;
        if (covered && !window) alpha *= std::exp(-below / kFade_mm);
        float shade = 0.55f + 0.45f * inside.facing[i] / 255.0f;
        if (options.depth_cue) shade *= 1.0f - 0.35f * (inside.depth_mm[i] - nearest_mm_) / range;
        Mix(out, inner == GeometryBuffers::Tumour ? kTumour : kInternal, shade, alpha);
      };
      if (inner && !covered) paint_organ(wash);
      if (inner) paint_inner();
      if (!inner) paint_organ(wash);
      if (inner && covered)
        paint_organ(outer == GeometryBuffers::CutFace ? 0.5f * wash : 0.6f * wash);
    }
}

void OverlayCompositor::Stroke(const PixelBox& box, const Color& color, double opacity,
                               Image* bgr) {
  const PixelBox wide = box.Grown(3, line_.Width(), line_.Height());
  if (box.Empty()) return;
  for (int y = wide.y0; y < wide.y1; ++y)
    std::copy(line_.Row(y) + wide.x0, line_.Row(y) + wide.x1, mask_.Row(y) + wide.x0);
  mask_.Smooth(wide, 1.8);
  mask_.Smooth(wide, 1.8);
  mask_.Blend(wide, {0, 0, 0}, 0.45 * opacity, bgr);
  line_.Blend(wide, color, opacity, bgr);
  mask_.Clear(wide);
  line_.Clear(wide);
}

void OverlayCompositor::PaintEdges(const OverlayOptions& options, const GeometryBuffer& front,
                                   const GeometryBuffer& inside, Image* bgr) {
  const int w = front.width;
  // There is no edge in an even part of `ids`; or, with `within`, where there is nothing.
  const auto draw = [&](const PixelBox& where, const Color& color, double opacity, double gain,
                        const std::vector<std::uint8_t>& ids, bool within, auto&& is_edge) {
    if (where.Empty()) return;
    // The image border is no edge of the organ.
    const PixelBox box{std::max(1, where.x0 - 2), std::max(1, where.y0 - 2),
                       std::min(w - 1, where.x1 + 2), std::min(front.height - 1, where.y1 + 2)};
    PixelBox drawn;
    for (int y = box.y0; y < box.y1; ++y) {
      std::uint8_t* row = line_.Row(y);
      int first = box.x1, last = -1;
      for (int x = box.x0; x < box.x1; ++x) {
        const std::size_t i = std::size_t(y) * w + x;
        if (x + 8 < box.x1 && !(within && ids[i]) && AllAlike(&ids[i], w)) {
          x += 7;
          continue;
        }
        if (!is_edge(i)) continue;
        row[x] = 255;
        first = std::min(first, x);
        last = x;
      }
      if (last < 0) continue;
      drawn.Include(first, y);
      drawn.Include(last, y);
    }
    drawn = drawn.Grown(1, line_.Width(), line_.Height());
    line_.Smooth(drawn, gain);
    Stroke(drawn, color, opacity, bgr);
  };
  // Both sides of a change of `what` are set: the line is centred on the true border.
  const auto border = [w](const std::vector<std::uint8_t>& ids, auto&& what) {
    return [&ids, what, w](std::size_t i) {
      const bool here = what(ids[i]);
      return here != what(ids[i - 1]) || here != what(ids[i + 1]) || here != what(ids[i - w]) ||
             here != what(ids[i + w]);
    };
  };
  const bool lines_only = options.preset == OverlayPreset::Outline;
  draw(internal_box_, kInternal, 0.9, lines_only ? 1.2 : 0.8, inside.surface, false,
       border(inside.surface, [](int s) { return s == GeometryBuffers::Internal; }));
  draw(tumour_box_, kTumour, 1.0, lines_only ? 1.4 : 1.0, inside.surface, false,
       border(inside.surface, [](int s) { return s == GeometryBuffers::Tumour; }));
  draw(front_box_, kOrgan, 0.7, 0.8, front.surface, true,
       [&](std::size_t i) { return front.surface[i] != 0 && IsDepthEdge(front, i); });
  draw(front_box_, kOrgan, 1.0, 1.4, front.surface, false,
       border(front.surface, [](int s) { return s != 0; }));
  draw(cut_box_, kCutLine, 1.0, 1.2, front.surface, false,
       border(front.surface, [](int s) { return s == GeometryBuffers::CutFace; }));
}

void OverlayCompositor::PaintMargins(const CameraModel& camera, const OverlayScene& scene,
                                     const GeometryBuffer& inside, Image* bgr) {
  const double u95 = scene.status.tumour_u95_mm, wanted = scene.status.planned_margin_mm;
  if (!(u95 > 0 || wanted > 0) || tumour_box_.Empty()) return;
  std::vector<std::uint8_t> tumour(inside.surface.size());
  double depth = 0;
  std::size_t count = 0;
  for (int y = tumour_box_.y0; y < tumour_box_.y1; ++y)
    for (int x = tumour_box_.x0; x < tumour_box_.x1; ++x) {
      const std::size_t i = std::size_t(y) * inside.width + x;
      if (inside.surface[i] != GeometryBuffers::Tumour) continue;
      tumour[i] = 1;
      depth += inside.depth_mm[i];
      ++count;
    }
  const auto radius_of = [&](double mm) {
    return mm > 0 ? std::min(0.5 * inside.height, mm * camera.fx * double(count) / depth) : 0.0;
  };
  const double widest = std::max(radius_of(u95), radius_of(wanted));
  const PixelBox box = tumour_box_.Grown(static_cast<int>(widest) + 4, inside.width, inside.height);
  const std::vector<float> distance = DistanceToMask(tumour, inside.width, box);
  const int w = box.x1 - box.x0;
  const Vec2 middle(0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1));
  const int dashes = std::max(12, static_cast<int>(0.25 * std::hypot(w, box.y1 - box.y0)));
  const auto ring = [&](double mm, bool dashed, const Color& color) {
    const double radius = radius_of(mm);
    if (!(radius > 0)) return;
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x) {
        const std::size_t i = std::size_t(y) * inside.width + x;
        // A small bound hugs the tumour; what lies before the tumour is no border of it.
        if (tumour[i] || inside.surface[i] == GeometryBuffers::Internal) continue;
        const double off = std::abs(distance[std::size_t(y - box.y0) * w + x - box.x0] - radius);
        if (off >= 1.5) continue;
        const double angle = std::atan2(y - middle.y(), x - middle.x()) + M_PI;
        const bool on = !dashed || static_cast<int>(angle / (2 * M_PI) * dashes * 2) % 2 == 0;
        if (on) line_.Row(y)[x] = static_cast<std::uint8_t>(255 * (1.5 - std::max(0.5, off)));
      }
    Stroke(box, color, 0.9, bgr);
  };
  ring(wanted, false, kPlanned);
  ring(u95, true, kTumour);
}

void OverlayCompositor::PaintLines(const CameraModel& camera, const OverlayScene& scene,
                                   Image* bgr) {
  for (const OverlayLine& line : scene.lines) {
    // Every 2 mm, so that a long straight piece bends with the lens.
    std::vector<Vec2> pixels;
    for (Eigen::Index i = 0; i + 1 < line.current.rows(); ++i) {
      const Vec3 a = line.current.row(i), b = line.current.row(i + 1);
      const int steps = std::clamp(static_cast<int>(std::ceil((b - a).norm() / 2.0)), 1, 200);
      for (int s = 0; s < steps + (i + 2 == line.current.rows()); ++s)
        pixels.push_back(camera.Project(a + (b - a) * (double(s) / steps)));
    }
    Pixels path(static_cast<Eigen::Index>(pixels.size()), 2);
    for (std::size_t i = 0; i < pixels.size(); ++i) path.row(i) = pixels[i].transpose();
    const bool planned = line.kind == OverlayLine::Kind::Planned;
    const bool proposed = line.kind == OverlayLine::Kind::Proposed;
    const PixelBox box = line_.DrawPolyline(path, planned ? 2.0 : 3.0,
                                            planned    ? 4.0
                                            : proposed ? 9.0
                                                       : 0.0);
    Stroke(box, planned ? kPlanned : kCutLine, 1.0, bgr);
  }
}

void OverlayCompositor::PaintFeatures(const FeatureSet& features, Image* bgr) {
  const struct {
    FeatureStatus status;
    Color color;
  } kinds[] = {{FeatureStatus::Tracked, {90, 255, 120}},
               {FeatureStatus::Lost, {150, 150, 150}},
               {FeatureStatus::Rejected, {255, 70, 60}},
               {FeatureStatus::Occluded, {255, 200, 60}}};
  for (const auto& kind : kinds) {
    PixelBox all;
    for (Index i = 0; i < features.Size(); ++i) {
      if (features.status[i] != kind.status) continue;
      const PixelBox box = line_.DrawDisc(features.pixels.row(i).transpose(), 2.0);
      if (box.Empty()) continue;
      all.Include(box.x0, box.y0);
      all.Include(box.x1 - 1, box.y1 - 1);
    }
    Stroke(all, kind.color, 0.9, bgr);
  }
}

void OverlayCompositor::KeepInstruments(const Image& mask, const Image& raw, Image* bgr) {
  PixelBox box;
  for (int y = 0; y < mask.height; ++y) {
    const std::uint8_t* in = mask.data.data() + std::size_t(y) * mask.width;
    const std::uint8_t* end = in + mask.width;
    const std::uint8_t* first = std::find_if(in, end, [](std::uint8_t m) { return m != 0; });
    if (first == end) continue;
    std::transform(first, end, line_.Row(y) + (first - in),
                   [](std::uint8_t m) -> std::uint8_t { return m ? 255 : 0; });
    box.Include(static_cast<int>(first - in), y);
    box.Include(mask.width - 1, y);
  }
  box = box.Grown(2, mask.width, mask.height);
  line_.Smooth(box, 1.0);
  for (int y = box.y0; y < box.y1; ++y) {
    const std::uint8_t* keep = line_.Row(y);
    for (int x = box.x0; x < box.x1; ++x) {
      if (keep[x] == 0) continue;
      const std::size_t at = 3 * (std::size_t(y) * mask.width + x);
      for (int k = 0; k < 3; ++k)
        bgr->data[at + k] = static_cast<std::uint8_t>(
            (bgr->data[at + k] * (255 - keep[x]) + raw.data[at + k] * keep[x] + 127) / 255);
    }
  }
  line_.Clear(box);
}

}  // namespace kerf
