#include "Registration/JumpDetection.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "Registration/CutDetection.h"
#include "Registration/CutLine.h"
#include "Registration/CutLineFit.h"
#include "Registration/ModelUpdate.h"

namespace kerf {
namespace {

constexpr double kStep_mm = 2.0;  // a line grows by at least this much
/// What parts in all before a cut begins. A few tracks that drift at the organ's rim gave 2.6 mm,
/// true cuts 3.7 mm and more.
constexpr double kLeastTogether_mm = 3.0;
constexpr double kWide_mm = 1.2;        // a pair that parts by more parts widely
constexpr double kPoint_mm = 4.0;       // distance of the points of a committed line
constexpr double kReachSpacings = 2.5;  // an end nearer than this to the organ's rim goes over it
constexpr double kOver_mm = 6.0;        // and this far beyond
constexpr double kSameCut_mm = 12.0;    // evidence nearer than this to a cut belongs to it
constexpr double kAim_mm = 4.0;         // the last of a line gives the direction it leads in
constexpr double kAhead_mm = 20.0;  // evidence nearer than this ahead of a line goes on with it:
constexpr double kAhead = 0.8;      // the tool hides what lies between; cosine of "ahead"

struct Evidence {
  Index pairs = 0, wide = 0;
  double excess_mm = 0.0;
};

Evidence EvidenceOf(const std::vector<PartingEdge>& parting, const std::vector<Index>& group) {
  Evidence evidence;
  for (Index i : group) {
    ++evidence.pairs;
    evidence.wide += parting[i].excess_mm > kWide_mm;
    evidence.excess_mm += parting[i].excess_mm;
  }
  return evidence;
}

/// Enough to begin a cut: three parting pairs, or two that part widely, and enough of it together.
bool BeginsCut(const Evidence& e) {
  return (e.pairs >= 3 || e.wide >= 2) && e.excess_mm > kLeastTogether_mm;
}

/// Enough to lead one on. Stretch ahead of the tip, that has lost the witness of the pairs behind
/// it (a feature was hidden), parted pairs by 0.9 mm.
bool LeadsOn(const Evidence& e) { return e.wide >= 1 || e.excess_mm > kLeastTogether_mm; }

/// The lateral plane seen from the organ: parallel rays along the optical axis.
class LateralFrame {
 public:
  LateralFrame(const CameraModel& camera, const SurfaceTree& rest)
      : world_from_camera_(camera.camera_from_world.inverse()), rest_(rest) {}
  std::optional<Vec3> OnOrgan(const Vec2& p) const {
    const auto hit = rest_.FirstHit(Through(p));
    if (!hit) return std::nullopt;
    return hit->point;
  }
  bool IsOnOrgan(const Vec2& p) const { return rest_.IsHit(Through(p)); }
  Vec3 AtDepth(const Vec2& p, double depth) const {
    return world_from_camera_ * Vec3(p.x(), p.y(), depth);
  }
  Vec2 Lateral(const Vec3& world) const { return (world_from_camera_.inverse() * world).head<2>(); }
  double Depth(const Vec3& world) const { return (world_from_camera_.inverse() * world).z(); }

 private:
  Ray Through(const Vec2& p) const {
    return {world_from_camera_ * Vec3(p.x(), p.y(), 0.0), world_from_camera_.linear().col(2)};
  }

  Eigen::Isometry3d world_from_camera_;
  const SurfaceTree& rest_;
};

/// Where a fitted line ends.
struct LineEnd {
  double at_mm = 0.0;     ///< t of the line
  bool over_rim = false;  ///< the surface says so, not the evidence alone
};

/// Over the organ's rim where that is near, else the extrapolated tip.
/// @param sign −1 begin, +1 end
LineEnd EndOf(const FittedLine& line, int sign, double spacing, const LateralFrame& frame) {
  const double last = sign > 0 ? line.end_mm : line.begin_mm;
  const double reach = kReachSpacings * spacing;
  for (double d = 0.0; d <= reach; d += 0.5)
    if (!frame.IsOnOrgan(line.At(last + sign * d))) return {last + sign * (d + kOver_mm), true};
  return {last + sign * (sign > 0 ? line.end_tip_mm : line.begin_tip_mm), false};
}

/// Points of the fitted line from t0 to t1 (either direction), on the organ where they are over it.
std::vector<Vec3> Trace(const FittedLine& line, double t0, double t1, double depth,
                        const LateralFrame& frame) {
  std::vector<Vec3> points;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(t1 - t0) / kPoint_mm)));
  for (int i = 0; i <= steps; ++i) {
    const Vec2 p = line.At(t0 + (t1 - t0) * i / steps);
    const auto on_organ = frame.OnOrgan(p);
    if (on_organ) depth = frame.Depth(*on_organ);
    points.push_back(frame.AtDepth(p, depth));
  }
  return points;
}

Points ToRows(const std::vector<Vec3>& points) {
  Points rows(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) rows.row(i) = points[i].transpose();
  return rows;
}

/// Where a point lies along the fitted line.
double Along(const FittedLine& line, const Eigen::RowVector3d& point, const LateralFrame& frame) {
  return line.tangent.dot(frame.Lateral(point.transpose()) - line.origin);
}

/// Grows a committed line at its ends to where the fitted line reaches; what is committed stays,
/// and an end that lies over the organ's rim is an end.
/// @param too_far_mm by this the evidence overshoots the committed line's first and last end
bool Grow(const FittedLine& line, const LineEnd& line_begin, const LineEnd& line_end, double depth,
          const LateralFrame& frame, const std::array<double, 2>& too_far_mm,
          CutPolyline* committed) {
  double begin = line_begin.at_mm, end = line_end.at_mm;
  if (committed->points.rows() == 0) {
    committed->points = ToRows(Trace(line, begin, end, depth, frame));
    return true;
  }
  const auto t_of = [&](Index row) { return Along(line, committed->points.row(row), frame); };
  // The fitted tangent may point against the committed order.
  const Index last = static_cast<Index>(committed->points.rows()) - 1;
  const bool forward = t_of(last) >= t_of(0);
  std::vector<Vec3> points;
  for (Index i = 0; i <= last; ++i) points.push_back(committed->points.row(i).transpose());
  if (!forward) std::reverse(points.begin(), points.end());
  if (!line_begin.over_rim) begin += too_far_mm[forward ? 0 : 1];
  if (!line_end.over_rim) end -= too_far_mm[forward ? 1 : 0];
  const double t_begin = t_of(forward ? 0 : last), t_end = t_of(forward ? last : 0);
  const auto on_organ = [&](const Vec3& p) { return frame.IsOnOrgan(frame.Lateral(p)); };
  const bool begin_open = on_organ(points.front()), end_open = on_organ(points.back());
  bool grew = false;
  if (end_open && end > t_end + kStep_mm) {
    for (const Vec3& p : Trace(line, std::min(t_end + kStep_mm, end), end, depth, frame))
      points.push_back(p);
    grew = true;
  }
  if (begin_open && begin < t_begin - kStep_mm) {
    for (const Vec3& p : Trace(line, std::max(t_begin - kStep_mm, begin), begin, depth, frame))
      points.insert(points.begin(), p);
    grew = true;
  }
  if (!forward) std::reverse(points.begin(), points.end());
  if (grew) committed->points = ToRows(points);
  return grew;
}

/// The fitted line as far as it or the committed one reaches, in the committed order.
Points Redrawn(const FittedLine& line, double begin, double end, double depth,
               const LateralFrame& frame, const Points& committed) {
  const double first = Along(line, committed.row(0), frame),
               last = Along(line, committed.row(committed.rows() - 1), frame);
  const double from = std::min({begin, first, last}), to = std::max({end, first, last});
  return ToRows(first <= last ? Trace(line, from, to, depth, frame)
                              : Trace(line, to, from, depth, frame));
}

/// How far ahead of an end of `known` the evidence along `line` begins, where it goes on in that
/// direction. @return 1e30 for nowhere ahead
double DistanceAhead_mm(const Points& known, const FittedLine& line, double depth,
                        const LateralFrame& frame) {
  double nearest = 1e30;
  for (const bool at_end : {false, true}) {
    const Points inner = Shortened(known, at_end, kAim_mm);
    if (inner.rows() == 0) continue;
    const Vec2 tip = frame.Lateral(known.row(at_end ? known.rows() - 1 : 0).transpose());
    const Vec2 from = frame.Lateral(inner.row(at_end ? inner.rows() - 1 : 0).transpose());
    const Vec2 on = (tip - from).normalized();
    if (std::abs(line.tangent.dot(on)) < kAhead) continue;  // across, not on
    for (const double t : {line.begin_mm, line.end_mm}) {
      const Vec2 way = frame.Lateral(frame.AtDepth(line.At(t), depth)) - tip;
      if (way.norm() < kAhead_mm && way.dot(on) > kAhead * way.norm())
        nearest = std::min(nearest, way.norm());
    }
  }
  return nearest;
}

/// Parting pairs that are drawn as one line, of a known cut or (−1) of a new one.
struct EvidenceOfCut {
  int cut = -1;
  Vec3 center;  ///< on the organ
  std::vector<Index> pairs;
  FittedLine line;
};

/// The groups, those that lie beside one cut or begin where it leads on together: an instrument
/// that hides the pairs between does not make two cuts of it. A cut that begins now counts as one.
std::vector<EvidenceOfCut> ByCut(const std::vector<PartingEdge>& parting,
                                 const FeatureTriangulation& t, const DisplacementJumps& jumps,
                                 const std::vector<ModelCut>& cuts, const LateralFrame& frame) {
  std::vector<EvidenceOfCut> all;
  struct Known {
    Points line;
    int cut = -1;
    std::optional<std::size_t> drawn = {};  ///< in `all`
  };
  std::vector<Known> known;
  for (std::size_t c = 0; c < cuts.size(); ++c)
    known.push_back({cuts[c].line.points, static_cast<int>(c)});
  for (const auto& group : GroupParting(parting, t)) {
    const FittedLine line = FitCutLine(parting, group, t, jumps);
    const auto center = frame.OnOrgan(line.At(0.5 * (line.begin_mm + line.end_mm)));
    if (!center) continue;
    const double depth = frame.Depth(*center);
    Known* owner = nullptr;
    double nearest = 1e30;
    for (Known& one : known) {
      double distance = DistanceToLine(one.line, *center);
      if (distance >= kSameCut_mm) distance = DistanceAhead_mm(one.line, line, depth, frame);
      if (distance >= nearest) continue;
      nearest = distance;
      owner = &one;
    }
    if (owner && owner->drawn) {
      EvidenceOfCut& drawn = all[*owner->drawn];
      drawn.pairs.insert(drawn.pairs.end(), group.begin(), group.end());
      drawn.line = FitCutLine(parting, drawn.pairs, t, jumps);
      continue;
    }
    if (owner)
      owner->drawn = all.size();
    else if (BeginsCut(EvidenceOf(parting, group)))
      known.push_back({ToRows(Trace(line, EndOf(line, -1, t.spacing_mm, frame).at_mm,
                                    EndOf(line, +1, t.spacing_mm, frame).at_mm, depth, frame)),
                       -1, all.size()});
    all.push_back({owner ? owner->cut : -1, *center, group, line});
  }
  return all;
}

}  // namespace

std::vector<CutEvent> DetectCutsByJumps(const Pixels& lateral, const std::vector<char>& usable,
                                        const CameraModel& camera, const MethodOptions& options,
                                        RegistrationState* state) {
  std::vector<CutEvent> events;
  CutEvidence& evidence = state->evidence;
  const FeatureTriangulation& t = evidence.triangulation;
  if (t.Empty()) return events;
  DisplacementJumps jumps = MeasureJumps(t, lateral, usable);
  DoubtReturned(t, usable, &evidence, &jumps);
  const auto parting = WithoutRefused(UpdateEvidence(jumps, lateral, &evidence), evidence);
  if (parting.empty()) return events;
  const LateralFrame frame(camera, *state->uncut);
  const Vec3 direction = options.extrusion ? *options.extrusion : camera.ViewDirection();
  for (const EvidenceOfCut& drawn : ByCut(parting, t, jumps, state->cuts, frame)) {
    const FittedLine& line = drawn.line;
    int cut_index = drawn.cut;
    CutEvent event;
    event.first = cut_index < 0;
    event.point = drawn.center;
    const Evidence weight = EvidenceOf(parting, drawn.pairs);
    if (event.first ? !BeginsCut(weight) : !LeadsOn(weight)) continue;
    const LineEnd begin = EndOf(line, -1, t.spacing_mm, frame);
    const LineEnd end = EndOf(line, +1, t.spacing_mm, frame);
    const double depth = frame.Depth(drawn.center);
    if (!event.first) {
      ModelCut& cut = state->cuts[cut_index];
      cut.redrawn = Redrawn(line, begin.at_mm, end.at_mm, depth, frame, cut.line.points);
    }
    ModelCut grown = event.first ? ModelCut() : state->cuts[cut_index];
    if (!Grow(line, begin, end, depth, frame, grown.too_far_mm, &grown.line)) continue;
    grown.confidence = std::max(grown.confidence, 1.0 - std::exp(-weight.excess_mm / 3.0));
    if (event.first) {
      grown.detected_frame = state->frame;
      grown.held = options.hold_cuts;
    }
    if (event.first) {  // what a cut has it keeps: the old part of S stays bit for bit
      grown.direction = direction;
      grown.view = camera.ViewDirection();
      grown.depth_mm = options.cut_depth_mm.value_or(ThroughDepth_mm(state->mesh, direction));
    }
    grown.surface = ExtrudeCut(grown.line, grown.direction, grown.depth_mm);
    if (event.first) {
      cut_index = static_cast<int>(state->cuts.size());
      state->cuts.push_back(grown);
    } else {
      state->cuts[cut_index] = grown;
    }
    event.cut = cut_index;
    events.push_back(event);
  }
  return events;
}

}  // namespace kerf
