#include "Meshing/SurfaceDomain.h"

#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/make_mesh_3.h>

#include <algorithm>
#include <array>

#include "Meshing/Mesh3.h"
#include "Meshing/Soup.h"

namespace kerf {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polyhedron = CGAL::Mesh_polyhedron_3<Kernel>::type;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index,
                                                        Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

constexpr double kSharpEdge_deg = 50.0;

class SurfaceDomain : public DomainMesher {
 public:
  explicit SurfaceDomain(const SurfaceMesh& surface) : volume_mm3_(surface.SignedVolume()) {
    std::vector<Kernel::Point_3> points;
    std::vector<std::array<std::size_t, 3>> triangles;
    ToSoup(surface, &points, &triangles);
    CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, triangles, polyhedron_);
  }

  double Volume_mm3() const override { return volume_mm3_; }
  bool HasOffset() const override { return false; }

  TetMesh Mesh(const MesherRun& run, Progress& progress) const override {
    progress.ThrowIfCancelled();
    // The generator drives where the first points are shot: the same ones on every run.
    CGAL::Random random(0);
    Domain domain(polyhedron_, &random);
    domain.detect_features(kSharpEdge_deg);
    namespace parameters = CGAL::parameters;
    const Criteria criteria(parameters::edge_size = run.edge_mm, parameters::facet_angle = 28,
                            parameters::facet_size = run.edge_mm,
                            parameters::facet_distance = 0.05 * std::min(run.edge_mm, 8.0),
                            parameters::cell_radius_edge_ratio = 2.0,
                            parameters::cell_size = run.edge_mm);
    Complex complex = CGAL::make_mesh_3<Complex>(domain, criteria, parameters::non_manifold(),
                                                 parameters::no_perturb(), parameters::no_exude());
    if (run.improve)
      CGAL::perturb_mesh_3(complex, domain, parameters::sliver_bound = run.sliver_bound_deg,
                           parameters::time_limit = 0);
    return ToTetMesh(complex, [](int) { return static_cast<int>(Label::Organ); });
  }

 private:
  double volume_mm3_;
  Polyhedron polyhedron_;
};

}  // namespace

std::unique_ptr<DomainMesher> MakeSurfaceDomain(const SurfaceMesh& surface) {
  return std::make_unique<SurfaceDomain>(surface);
}

}  // namespace kerf
