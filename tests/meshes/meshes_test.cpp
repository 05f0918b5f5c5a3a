// The meshes made at build time: exact counts, solid, sized in metres, and the peg fits into the hole.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

BOOST_AUTO_TEST_SUITE(meshes_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

/// The mesh, which must need neither repair nor warning.
TriangleMesh made(const std::string& name) {
  const TemporaryFolder cache;
  SolidFile solid = load_solid(std::string(TACTOR_BINARY_DIR) + "/meshes/" + name + ".off", cache.path());
  BOOST_TEST((solid.report == MeshReport{}));
  return std::move(solid.mesh);
}

/// Vertices - edges + faces: 2 for a sphere, 0 for a surface with one handle.
long euler(const TriangleMesh& mesh) {
  return static_cast<long>(mesh.vertices.size()) - static_cast<long>(mesh.faces.size()) / 2;
}

double regular_polygon(double radius) {
  return 0.5 * 43 * radius * radius * std::sin(2 * std::numbers::pi / 43);
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_mesh_has_its_exact_count_and_is_solid) {
  for (const auto& [name, faces, characteristic] :
       {std::tuple{"duck", 13926U, 2L}, std::tuple{"bunny", 20990U, 2L}, std::tuple{"liver", 2600U, 2L},
        std::tuple{"peg", 168U, 2L}, std::tuple{"plate", 188U, 0L}}) {
    const TriangleMesh mesh = made(name);
    BOOST_TEST(mesh.faces.size() == faces);
    BOOST_TEST(euler(mesh) == characteristic);
  }
}

BOOST_AUTO_TEST_CASE(duck_and_bunny_are_sized_in_metres) {
  const Vec3 duck = bounds_of(made("duck")).size();
  BOOST_TEST(duck.x == 0.1, tt::tolerance(0.15));
  BOOST_TEST(bounds_of(made("bunny")).size().y == 0.15, tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(the_liver_is_143_by_105_by_57_mm) {
  const Vec3 size = bounds_of(made("liver")).size();
  BOOST_TEST(size.x == 0.143, tt::tolerance(0.02));
  BOOST_TEST(size.y == 0.105, tt::tolerance(0.02));
  BOOST_TEST(size.z == 0.057, tt::tolerance(0.02));
  BOOST_TEST(mass_properties(made("liver")).volume == 3.5e-4, tt::tolerance(0.03));
}

BOOST_AUTO_TEST_CASE(peg_and_plate_have_the_volume_of_their_polygons) {
  BOOST_TEST(mass_properties(made("peg")).volume == regular_polygon(0.01) * 0.05, tt::tolerance(1e-9));
  BOOST_TEST(mass_properties(made("plate")).volume == (0.0064 - regular_polygon(0.0105)) * 0.02, tt::tolerance(1e-9));
  BOOST_TEST(norm(mass_properties(made("peg")).center) < 1e-12);
  BOOST_TEST(norm(mass_properties(made("plate")).center) < 1e-12);
}

BOOST_AUTO_TEST_CASE(the_peg_stands_in_the_hole_with_half_a_millimetre_around_it) {
  const TriangleMesh peg = made("peg"), plate = made("plate");
  double peg_radius = 0, hole_radius = 1;
  for (const Vec3& v : peg.vertices) peg_radius = std::max(peg_radius, std::hypot(v.x, v.y));
  for (const Vec3& v : plate.vertices) hole_radius = std::min(hole_radius, std::hypot(v.x, v.y));
  BOOST_TEST(hole_radius - peg_radius == 0.0005, tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_SUITE_END()
