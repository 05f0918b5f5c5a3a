// What every mesh of tetrahedra must be.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include <boost/test/unit_test.hpp>

#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/tet_quality.hpp"
#include "nodes/physics/mesh/tet_topology.hpp"

namespace tactor::test {

/// Volumes are positive, every node is used, the boundary is closed and outward and encloses the volume of the
/// tetrahedra (Gauss), and each edge of it has the number of faces that a closed manifold has.
inline void check_sound(const TetMesh& mesh, bool is_manifold = true) {
  BOOST_TEST_REQUIRE(!mesh.tets.empty());
  std::set<int> used;
  double smallest = 1e300;
  for (const auto& tet : mesh.tets) {
    used.insert(tet.begin(), tet.end());
    smallest = std::min(smallest, volume_of(corners_of(mesh, tet)));
  }
  BOOST_TEST(smallest > 0);
  BOOST_TEST(used.size() == mesh.nodes.size());
  BOOST_TEST(*used.begin() == 0);
  BOOST_TEST(*used.rbegin() == static_cast<int>(mesh.nodes.size()) - 1);
  BOOST_TEST(find_overlap(mesh) == "");
  std::map<std::pair<int, int>, int> edges;
  for (const auto& f : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{f[k], f[(k + 1) % 3]}];
  }
  int unmatched = 0, repeated = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    unmatched += back == edges.end() || back->second != count ? 1 : 0;
    repeated += count > 1 ? 1 : 0;
  }
  BOOST_TEST(unmatched == 0);
  if (is_manifold) BOOST_TEST(repeated == 0);
  BOOST_TEST(mass_properties(surface_of(mesh)).volume == quality_of(mesh).volume, boost::test_tools::tolerance(1e-9));
}

}  // namespace tactor::test
