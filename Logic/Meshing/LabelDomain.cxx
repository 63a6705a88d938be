#include "Meshing/LabelDomain.h"

#include <CGAL/Labeled_mesh_domain_3.h>

#include <algorithm>
#include <cmath>

#include "Meshing/Mesh3.h"

namespace kerf {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
using Point = Kernel::Point_3;

constexpr int kOutside = 0;
constexpr int kOrgan = static_cast<int>(Label::Organ);
constexpr int kTumour = static_cast<int>(Label::Tumour);

/// Smaller cells in and around a tumour that is small for the organ's cells.
struct Sizing {
  using FT = double;
  using Point_3 = Point;
  using Index = Domain::Index;
  double organ_mm, tumour_mm;
  FT operator()(const Point_3&, const int dimension, const Index& index) const {
    if (dimension == 3) return boost::get<int>(index) == kTumour ? tumour_mm : organ_mm;
    const auto& patch = boost::get<Domain::Surface_patch_index>(index);
    return patch.first == kTumour || patch.second == kTumour ? tumour_mm : organ_mm;
  }
};

class LabelDomain : public DomainMesher {
 public:
  LabelDomain(const LabelField& organ, const LabelField& tumour) : organ_(organ), tumour_(tumour) {
    organ_seeds_ = InteriorSeeds(organ);
    if (!tumour.Empty()) tumour_seeds_ = InteriorSeeds(tumour);
  }

  double Volume_mm3() const override { return organ_.voxel_volume_mm3; }

  TetMesh Mesh(const MesherRun& run, Progress& progress) const override {
    // An offset moves the level: outwards means a lower one. Kept where the field still falls.
    const double organ_level =
        std::clamp(organ_.level - run.offset_mm * organ_.slope_per_mm, 0.15, 0.85);
    long calls = 0;
    const auto label = [&, organ_level](const Point& p) {
      // The only place that the mesher visits often: cancelled by unwinding it.
      if ((++calls & 0xFFF) == 0) progress.ThrowIfCancelled();
      const Vec3 x(p.x(), p.y(), p.z());
      if (organ_.At(x) <= organ_level) return kOutside;
      if (!tumour_.Empty() && tumour_.Inside(x)) return kTumour;
      return kOrgan;
    };
    const GridGeometry& grid = organ_.grid;
    const Vec3 center = grid.WorldFromIndex(0.5 * (grid.size.array() - 1).matrix().cast<double>());
    const double radius = 0.5 * grid.spacing_mm.cwiseProduct(grid.size.cast<double>()).norm();
    CGAL::Random random(0);
    namespace parameters = CGAL::parameters;
    const Domain domain(parameters::function = label,
                        parameters::bounding_object = Kernel::Sphere_3(
                            Point(center[0], center[1], center[2]), radius * radius),
                        parameters::relative_error_bound = 1e-6, parameters::p_rng = &random);

    Complex complex;
    InsertInitialPoints(label, radius, &complex, domain);
    const double tumour_edge = TumourEdge_mm(run.edge_mm);
    const Sizing size{run.edge_mm, tumour_edge};
    const Criteria criteria(parameters::facet_angle = 30, parameters::facet_size = size,
                            parameters::facet_distance = 0.1 * std::min(run.edge_mm, 8.0),
                            parameters::cell_radius_edge_ratio = 2.0, parameters::cell_size = size);
    CGAL::refine_mesh_3(complex, domain, criteria, parameters::no_reset_c3t3(),
                        parameters::no_perturb(), parameters::no_exude());
    // No time limit: what is done must not depend on the clock.
    if (run.improve)
      CGAL::perturb_mesh_3(complex, domain, parameters::sliver_bound = run.sliver_bound_deg,
                           parameters::time_limit = 0);
    return ToTetMesh(complex, [](int subdomain) { return subdomain; });
  }

 private:
  double TumourEdge_mm(double organ_edge_mm) const {
    if (tumour_.Empty()) return organ_edge_mm;
    const double radius = std::cbrt(tumour_.voxel_volume_mm3 * 3.0 / (4.0 * M_PI));
    return std::clamp(0.6 * radius, 0.25 * organ_edge_mm, organ_edge_mm);
  }

  /// Points on every boundary, found from a deepest voxel of each part: random rays would miss
  /// small tumours.
  template <typename LabelAt>
  void InsertInitialPoints(const LabelAt& label, double radius, Complex* complex,
                           const Domain& domain) const {
    const double step = 0.4 * organ_.grid.spacing_mm.minCoeff();
    const auto shoot = [&](const Vec3& seed, int rays) {
      const int inside = label(Point(seed[0], seed[1], seed[2]));
      if (inside == kOutside) return;
      for (int r = 0; r < rays; ++r) {
        // Directions spread evenly over the sphere (Fibonacci spiral).
        const double z = 1.0 - (2.0 * r + 1.0) / rays, turn = 2.399963229728653 * r;
        const Vec3 direction(std::sqrt(1 - z * z) * std::cos(turn),
                             std::sqrt(1 - z * z) * std::sin(turn), z);
        const auto at = [&](double t) {
          const Vec3 x = seed + t * direction;
          return Point(x[0], x[1], x[2]);
        };
        double near = 0.0, far = step;
        while (far < 2.0 * radius && label(at(far)) == inside) near = far, far += step;
        if (far >= 2.0 * radius) continue;
        for (int i = 0; i < 40; ++i) {
          const double middle = 0.5 * (near + far);
          (label(at(middle)) == inside ? near : far) = middle;
        }
        const auto patch = domain.surface_patch_index(
            domain.index_from_surface_patch_index(MakePatch(inside, label(at(far)))));
        const auto vertex =
            complex->triangulation().insert(Triangulation::Weighted_point(at(0.5 * (near + far))));
        if (vertex == Complex::Vertex_handle()) continue;
        complex->set_dimension(vertex, 2);
        complex->set_index(vertex, domain.index_from_surface_patch_index(patch));
      }
    };
    for (std::size_t s = 0; s < organ_seeds_.size() && s < 4; ++s) shoot(organ_seeds_[s], 60);
    for (std::size_t s = 0; s < tumour_seeds_.size() && s < 16; ++s) shoot(tumour_seeds_[s], 24);
  }
  static Domain::Surface_patch_index MakePatch(int a, int b) {
    return {std::min(a, b), std::max(a, b)};
  }

  const LabelField& organ_;
  const LabelField& tumour_;
  std::vector<Vec3> organ_seeds_, tumour_seeds_;
};

}  // namespace

std::unique_ptr<DomainMesher> MakeLabelDomain(const LabelField& organ, const LabelField& tumour) {
  return std::make_unique<LabelDomain>(organ, tumour);
}

}  // namespace kerf
