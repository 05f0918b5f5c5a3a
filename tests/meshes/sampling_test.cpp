// The samples of the meshes that the scenes use.
#include <boost/test/unit_test.hpp>

#include "nodes/physics/mesh/solid_file.hpp"
#include "tests/nodes/physics/mesh/covering.hpp"

BOOST_AUTO_TEST_SUITE(sampling_test)

using namespace tactor;

namespace {

TriangleMesh load(const std::string& name) {
  return load_solid(std::string(TACTOR_BINARY_DIR) + "/meshes/" + name + ".off").mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(samples_cover_the_meshes_of_the_scenes_within_their_spacing) {
  const auto check = [](const std::string& name, double spacing, int points) {
    BOOST_TEST_CONTEXT(name << ", spacing " << spacing) {
      const TriangleMesh mesh = load(name);
      const std::vector<SurfaceSample> samples = sample_surface(mesh, spacing).points;
      BOOST_TEST(test::covering_distance(mesh, samples, points) <= spacing);
      BOOST_TEST(test::total_area(samples) == surface_area(mesh), boost::test_tools::tolerance(1e-9));
    }
  };
  for (const double spacing : {0.004, 0.002}) {
    check("peg", spacing, 20'000);
    check("plate", spacing, 20'000);
  }
  for (const double spacing : {0.008, 0.004}) check("bunny", spacing, 4'000);
}

BOOST_AUTO_TEST_CASE(slivers_of_the_plate_do_not_multiply_its_samples) {
  for (const std::string name : {"peg", "plate"}) {
    const TriangleMesh mesh = load(name);
    for (const double spacing : {0.004, 0.002}) {
      // What squares of 0.85 spacing, the least distance between samples, have room for.
      const double room = surface_area(mesh) / (0.85 * 0.85 * spacing * spacing);
      BOOST_TEST(static_cast<double>(sample_surface(mesh, spacing).points.size()) < room);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
