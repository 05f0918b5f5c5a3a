// The boundary of tetrahedra, the order of their nodes, and boxes of them.
#include <cmath>
#include <numbers>

#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/box_volume.hpp"
#include "tests/nodes/physics/mesh/volume_checks.hpp"

BOOST_AUTO_TEST_SUITE(tet_topology_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

/// Two tetrahedra on either side of the triangle 0 1 2.
TetMesh two() {
  TetMesh mesh;
  mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_boundary_leaves_out_faces_that_tetrahedra_share) {
  TetMesh mesh = two();
  finish_mesh(mesh);
  BOOST_TEST(mesh.faces.size() == 6U);
  test::check_sound(mesh);
  BOOST_TEST(pieces_of(mesh) == 1U);
  BOOST_TEST((surface_nodes(mesh) == std::vector<int>{0, 1, 2, 3, 4}));
}

BOOST_AUTO_TEST_CASE(nodes_inside_are_none_of_the_surface) {
  // A tetrahedron cut into four about its middle.
  TetMesh mesh;
  mesh.nodes = {{0, 0, 0}, {0.25, 0.25, 0.25}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tets = {{1, 2, 3, 4}, {0, 1, 3, 4}, {0, 2, 1, 4}, {0, 2, 3, 1}};
  finish_mesh(mesh);
  test::check_sound(mesh);
  BOOST_TEST((surface_nodes(mesh) == std::vector<int>{0, 2, 3, 4}));
  const TriangleMesh surface = surface_of(mesh);
  BOOST_TEST(surface.vertices.size() == 4U);
  BOOST_TEST(surface.faces.size() == 4U);
  BOOST_TEST((surface.vertices[1] == Vec3{1, 0, 0}));
}

BOOST_AUTO_TEST_CASE(unused_nodes_are_dropped_with_the_faces_that_name_them) {
  TetMesh mesh = two();
  mesh.nodes.insert(mesh.nodes.begin(), Vec3{9, 9, 9});
  for (auto& tet : mesh.tets) {
    for (int& i : tet) ++i;
  }
  // Node 0 is gone. The second face of `top` is of the boundary, but turned; that of `middle` is inside.
  mesh.groups = {{"top", {{0, 1, 2}, {2, 3, 4}}}, {"loose", {{0, 1, 2}}}, {"middle", {{1, 2, 3}}}};
  std::swap(mesh.groups[0].faces[1][0], mesh.groups[0].faces[1][1]);
  finish_mesh(mesh);
  BOOST_TEST(mesh.nodes.size() == 5U);
  BOOST_TEST_REQUIRE(mesh.groups.size() == 2U);
  BOOST_TEST(mesh.groups[0].name == "top");
  BOOST_TEST_REQUIRE(mesh.groups[0].faces.size() == 1U);
  BOOST_TEST(std::count(mesh.faces.begin(), mesh.faces.end(), mesh.groups[0].faces[0]) == 1);
  BOOST_TEST(mesh.groups[1].name == "middle");
  test::check_sound(mesh);
}

BOOST_AUTO_TEST_CASE(tetrahedra_on_the_same_side_of_a_face_overlap) {
  BOOST_TEST(find_overlap(two()) == "");
  TetMesh mesh = two();
  mesh.nodes[4] = {0.2, 0.2, 2};
  std::swap(mesh.tets[1][0], mesh.tets[1][1]);
  BOOST_TEST(find_overlap(mesh).starts_with("tetrahedra 0 and 1 overlap"));
  mesh = two();
  mesh.nodes.push_back({1, 1, -1});
  mesh.tets.push_back({0, 2, 1, 5});
  BOOST_TEST(find_overlap(mesh).find("share a face with tetrahedron 2") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(ordering_by_place_keeps_the_mesh_and_forgets_the_former_order) {
  TetMesh mesh = box_volume({0.03, 0.02, 0.01}, {6, 4, 2});
  mesh.faces.clear();
  TetMesh shuffled = mesh;
  // Numbers nodes and lists tetrahedra the other way round.
  const int last = static_cast<int>(mesh.nodes.size()) - 1;
  std::reverse(shuffled.nodes.begin(), shuffled.nodes.end());
  for (auto& tet : shuffled.tets) tet = {last - tet[1], last - tet[0], last - tet[3], last - tet[2]};
  std::reverse(shuffled.tets.begin(), shuffled.tets.end());
  order_by_place(mesh);
  order_by_place(shuffled);
  finish_mesh(mesh);
  finish_mesh(shuffled);
  test::check_sound(mesh);
  test::check_sound(shuffled);
  BOOST_TEST((mesh.nodes == shuffled.nodes));
  BOOST_TEST(quality_of(mesh).volume == 6e-6, tt::tolerance(1e-12));
  // Nodes of a tetrahedron lie nearer each other in memory than in rows of the box.
  BOOST_TEST(norm(mesh.nodes[0] - mesh.nodes[1]) < 0.008);
}

BOOST_AUTO_TEST_CASE(pieces_hang_together_by_nodes) {
  TetMesh mesh = two();
  mesh.nodes.insert(mesh.nodes.end(), {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {5, 0, 1}});
  mesh.tets.push_back({5, 6, 7, 8});
  BOOST_TEST(pieces_of(mesh) == 2U);
  mesh.tets.push_back({4, 6, 5, 7});
  BOOST_TEST(pieces_of(mesh) == 1U);
}

BOOST_AUTO_TEST_CASE(a_box_is_filled_exactly_whatever_its_cells) {
  for (const std::array<std::size_t, 3>& cells :
       {std::array<std::size_t, 3>{1, 1, 1}, {2, 1, 1}, {1, 3, 2}, {5, 4, 3}, {4, 4, 4}}) {
    const Vec3 size{0.05, 0.04, 0.03};
    const TetMesh mesh = box_volume(size, cells);
    BOOST_TEST(mesh.tets.size() == 5 * cells[0] * cells[1] * cells[2]);
    BOOST_TEST(mesh.nodes.size() == (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1));
    BOOST_TEST(mesh.faces.size() == 4 * (cells[0] * cells[1] + cells[1] * cells[2] + cells[2] * cells[0]));
    test::check_sound(mesh);
    BOOST_TEST(quality_of(mesh).volume == 6e-5, tt::tolerance(1e-12));
    BOOST_TEST(surface_area(surface_of(mesh)) == 2 * (0.05 * 0.04 + 0.04 * 0.03 + 0.03 * 0.05), tt::tolerance(1e-12));
  }
}

BOOST_AUTO_TEST_CASE(cubes_have_angles_of_54_7_degrees_or_more) {
  BOOST_TEST(quality_of(box_volume({0.04, 0.04, 0.04}, {3, 3, 3})).smallest_angle == std::acos(1 / std::sqrt(3.0)),
             tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(cells_are_near_cubes_and_their_count_near_what_is_asked_for) {
  for (const Vec3& size : {Vec3{0.1, 0.1, 0.1}, {0.2, 0.05, 0.03}, {0.3, 0.02, 0.02}, {0.1, 0.1, 0.005}}) {
    for (const std::size_t wanted : {500U, 1000U, 3000U, 10000U, 30000U}) {
      const auto cells = box_cells(size, {.tetrahedra = wanted});
      const double count = 5.0 * static_cast<double>(cells[0] * cells[1] * cells[2]);
      BOOST_TEST_CONTEXT(size.x << " x " << size.y << " x " << size.z << ", " << wanted << ": " << cells[0] << ' '
                                << cells[1] << ' ' << cells[2]) {
        BOOST_TEST(std::abs(count / static_cast<double>(wanted) - 1) < 0.11);
        double shortest = 1, longest = 0;
        for (int axis = 0; axis < 3; ++axis) {
          const double edge = size[axis] / static_cast<double>(cells[static_cast<std::size_t>(axis)]);
          shortest = std::min(shortest, edge), longest = std::max(longest, edge);
        }
        BOOST_TEST(longest / shortest < 2.01);
      }
    }
  }
  BOOST_TEST((box_cells({0.1, 0.05, 0.01}, {.edge = 0.01}) == std::array<std::size_t, 3>{10, 5, 1}));
  BOOST_TEST((box_cells({0.1, 0.05, 0.001}, {.edge = 0.02}) == std::array<std::size_t, 3>{5, 3, 1}));
  BOOST_TEST((box_cells({0.1, 0.1, 0.1}, {.tetrahedra = 1}) == std::array<std::size_t, 3>{1, 1, 1}));
}

BOOST_AUTO_TEST_SUITE_END()
