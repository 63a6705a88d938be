#include "Cutting/CutAssembly.h"

#include <algorithm>
#include <numeric>

#include "Cutting/DisjointSets.h"

namespace kerf {

TopologyChange Unchanged(const TetMesh& mesh, Index vertices, Index tets) {
  TopologyChange change;
  change.mesh.rest.resize(vertices, 3);
  change.mesh.rest.topRows(mesh.VertexCount()) = mesh.rest;
  change.mesh.tets.resize(tets, 4);
  change.mesh.tets.topRows(mesh.TetCount()) = mesh.tets;
  change.mesh.region.reserve(tets);
  change.mesh.region = mesh.region;
  change.mesh.region.resize(tets);
  change.vertex_parents.resize(vertices);
  change.vertex_weights.resize(vertices, 4);
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    change.vertex_parents[v].fill(v);
    change.vertex_weights.row(v) << 1, 0, 0, 0;
  }
  change.parent_tet.resize(tets);
  std::iota(change.parent_tet.begin(), change.parent_tet.begin() + mesh.TetCount(), 0);
  change.kept_tet.assign(change.parent_tet.begin(), change.parent_tet.begin() + mesh.TetCount());
  return change;
}

TopologyChange Assemble(const TetMesh& mesh, const CutPatch& before, const CutPatch& patch,
                        const std::vector<OpenedFace>& opened) {
  std::vector<Index> number(patch.vertices.size());
  Index vertex_count = mesh.VertexCount();
  for (std::size_t v = 0; v < patch.vertices.size(); ++v)
    number[v] = patch.vertices[v].old_vertex >= 0 ? patch.vertices[v].old_vertex : vertex_count++;
  std::vector<Index> places;  // of changed old tetrahedra
  for (std::size_t t = 0; t < before.tets.size(); ++t)
    if (patch.tets[t].changed) places.push_back(before.old_tet[t]);
  const Index fresh = static_cast<Index>(
      std::count_if(patch.tets.begin(), patch.tets.end(), [](const auto& t) { return t.changed; }));
  Index tet_count = mesh.TetCount();
  TopologyChange change =
      Unchanged(mesh, vertex_count, tet_count + fresh - static_cast<Index>(places.size()));
  change.changed = true;
  for (Index t : places) change.kept_tet[t] = -1;
  for (std::size_t v = 0; v < patch.vertices.size(); ++v) {
    const auto& vertex = patch.vertices[v];
    if (vertex.old_vertex >= 0 && !vertex.moved) continue;
    std::vector<int> sources;
    for (int t : patch.star[v]) sources.push_back(patch.tets[t].source);
    std::sort(sources.begin(), sources.end());
    sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
    Vec4 weights;
    const auto& holder = before.tets[before.Locate(vertex.rest, sources, &weights)].v;
    change.mesh.rest.row(number[v]) = vertex.rest.transpose();
    for (int k = 0; k < 4; ++k)
      if ((weights - Vec4::Unit(k)).cwiseAbs().maxCoeff() < 1e-12)
        weights = Vec4::Unit(k);  // a copy of an old vertex
    change.vertex_weights.row(number[v]) = weights.transpose();
    for (int k = 0; k < 4; ++k)
      change.vertex_parents[number[v]][k] = before.vertices[holder[k]].old_vertex;
  }
  std::size_t next_place = 0;
  std::vector<Index> tet_number(patch.tets.size());
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const auto& tet = patch.tets[t];
    if (!tet.changed) {
      tet_number[t] = before.old_tet[t];
      continue;
    }
    const Index at = next_place < places.size() ? places[next_place++] : tet_count++;
    Vec3 center = Vec3::Zero();
    for (int k = 0; k < 4; ++k) {
      change.mesh.tets(at, k) = number[tet.v[k]];
      center += patch.vertices[tet.v[k]].rest / 4;
    }
    Vec4 weights;
    change.parent_tet[at] = before.old_tet[before.Locate(center, {tet.source}, &weights)];
    change.mesh.region[at] = tet.region;
    change.new_tets.push_back(at);
    tet_number[t] = at;
  }
  std::sort(change.new_tets.begin(), change.new_tets.end());
  for (OpenedFace face : opened) {
    for (int k = 0; k < 3; ++k) {
      face.a[k] = number[face.a[k]];
      face.b[k] = number[face.b[k]];
    }
    face.tet_a = tet_number[face.tet_a];
    face.tet_b = tet_number[face.tet_b];
    change.opened.push_back(face);
  }
  return change;
}

std::vector<double> ComponentVolumes_mm3(const TetMesh& mesh) {
  DisjointSets joined(mesh.VertexCount());
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int k = 1; k < 4; ++k) joined.Join(mesh.tets(t, 0), mesh.tets(t, k));
  std::vector<int> component(mesh.VertexCount(), -1);
  std::vector<double> volumes;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    int& c = component[joined.Find(mesh.tets(t, 0))];
    if (c < 0) {
      c = static_cast<int>(volumes.size());
      volumes.push_back(0);
    }
    volumes[c] += TetVolume(mesh.rest, mesh.tets, t);
  }
  return volumes;
}

}  // namespace kerf
