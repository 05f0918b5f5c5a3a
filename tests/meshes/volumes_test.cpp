// The meshes that the scenes use can be filled with tetrahedra.
#include <cmath>
#include <numbers>

#include "nodes/physics/mesh/body_volume.hpp"
#include "tests/nodes/physics/mesh/volume_checks.hpp"

BOOST_AUTO_TEST_SUITE(volumes_test)

using namespace tactor;

namespace {

constexpr double degree = std::numbers::pi / 180;

Body deformable(const std::string& name, int tetrahedra) {
  Body body;
  body.name = name;
  body.shape = MeshShape{std::string(TACTOR_BINARY_DIR) + "/meshes/" + name + ".off"};
  body.motion = Motion::deformable;
  body.deformable.tetrahedra = tetrahedra;
  return body;
}

void check_filled(const std::string& name, int wanted, double volume_error) {
  const Body body = deformable(name, wanted);
  const double surface_volume = mass_properties(load_body_mesh(body)).volume;
  Notes notes;
  const BodyVolume filled = load_body_volume(body, &notes);
  for (const std::string& note : notes) BOOST_TEST_MESSAGE(note);
  test::check_sound(filled.mesh);
  const TetQuality quality = quality_of(filled.mesh);
  BOOST_TEST_CONTEXT(notes.front()) {
    BOOST_TEST(std::abs(static_cast<double>(filled.mesh.tets.size()) / wanted - 1) < 0.1);
    BOOST_TEST(quality.smallest_angle > 11 * degree);
    BOOST_TEST(std::abs(quality.volume / surface_volume - 1) < volume_error);
    BOOST_TEST(pieces_of(filled.mesh) == 1U);
    // Nothing but its numbers is to be told.
    BOOST_TEST(notes.size() == 1U);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_liver_the_duck_and_the_bunny_are_filled_with_as_many_tetrahedra_as_asked_for) {
  for (const char* name : {"liver", "duck", "bunny"}) {
    check_filled(name, 1000, 0.06);
    check_filled(name, 3000, 0.035);
    check_filled(name, 10000, 0.02);
  }
}

BOOST_AUTO_TEST_CASE(thirty_thousand_tetrahedra_fill_the_liver) {
  check_filled("liver", 30000, 0.01);
}

BOOST_AUTO_TEST_CASE(the_peg_and_the_plate_keep_their_edges) {
  check_filled("peg", 2000, 0.03);
  check_filled("plate", 5000, 0.01);
}

BOOST_AUTO_TEST_SUITE_END()
