// A rigid ball pressed into an elastic block by the contacts and steps that scenes have, against Hertz's closed form.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <numbers>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/deformable/suitesparse_plugin.hpp"
#include "tests/nodes/physics/deformable/graded_block.hpp"
#include "tests/nodes/physics/deformable/soft_rig.hpp"

BOOST_AUTO_TEST_SUITE(hertz_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double young = 2e4, poisson = 0.3, radius = 0.01;  // Pa, m
constexpr double reduced = young / (1 - poisson * poisson);  // Pa, E* against a rigid ball
/// Of each of the two materials. Both in series have twice the softness, so that a depth makes a pressure of
/// stiffness / 2 / area.
constexpr double stiffness = 4e5, area = 1e-4;  // N/m, m^2

/// N at depth d (m). The ball touches a half-space within a = sqrt(R d), with the pressure
/// p0 sqrt(1 - r^2 / a^2), p0 = 2 E* a / (pi R) (K. Johnson, "Contact Mechanics", 1985, chapter 4).
double hertz(double d) {
  return 4.0 / 3 * reduced * std::sqrt(radius) * std::pow(d, 1.5);
}
/// The depth that is left to the half-space at depth d of the ball, because the surface sinks into the ball by
/// pressure / k. By the complementary energy, to the first order of 1 / k, it is d less
///   d/dF integral(p^2 / (2 k) dA) = p0 / (2 k).
double depth_of_block(double d) {
  return d - std::numbers::inv_pi * reduced * std::sqrt(d / radius) / (stiffness / 2 / area);
}

/// The block, with elements of 2 core / cells under the ball. A face of a quadratic element is touched as four.
Grading grading_of(int cells) {
  return {.cells = cells, .core = 0.0012, .growth = 1.4, .shells = 13};
}
/// m. The ball touches within 0.59 to 0.89 mm, no more than a hundredth of how far the block reaches. A bonded layer as
/// deep would answer 0.6 to 0.8 % harder than a half-space (E. Dimitriadis et al., Biophysical Journal 82, 2002).
const std::vector<double> depths{3.5e-5, 5e-5, 6.5e-5, 8e-5};

/// The forces (N) at these depths, one after the other, each in steps that are too long for inertia to matter.
std::vector<double> press(int cells, Elasticity law, ElementOrder order) {
  const Grading grading = grading_of(cells);
  const TemporaryFolder folder;
  const auto file = folder.path() / "block.vtu";
  write_vtu(graded_block(grading), file);
  Body block = gel_box("block", {}, {}, young, 0);
  block.shape = MeshShape{file, 1};
  block.deformable.poisson = poisson;
  const double reach = grading.reach();
  block.deformable.fixed = {HalfSpaceRegion{{0, 0, -reach}, {0, 0, 1}}};
  for (const double side : {-1.0, 1.0}) {
    block.deformable.fixed.emplace_back(HalfSpaceRegion{{side * reach, 0, 0}, {-side, 0, 0}});
    block.deformable.fixed.emplace_back(HalfSpaceRegion{{0, side * reach, 0}, {0, -side, 0}});
  }
  Scene scene;
  scene.gravity_W = {};
  scene.bodies = {block, ball_tool(radius, {0, 0, radius}, 1e9)};  // so heavy that no force moves it
  for (Body& body : scene.bodies) {
    body.material = {.stiffness = stiffness, .damping = 0, .friction = 0, .patch_area = area};
  }
  SoftRig rig(scene, {.law = law,
                      .order = order,
                      .tolerance = 1e-6,
                      .reuse = true,
                      .patch_nodes = 32,
                      .patch_reach = 0.002,
                      .factor = FactorKind::automatic,
                      .margin = 1e-6,
                      .spacing = 0.01});
  std::vector<double> forces;
  double at = 0;
  for (const double depth : depths) {
    StepResult result;
    // Halfway, there, and once more: by then all nodes that are touched are in the patch.
    for (const double share : {0.5, 1.0, 1.0}) {
      rig.bodies.X_WB[0].p.z = radius - (at + share * (depth - at));
      rig.bodies.V_WB[0] = {};
      result = rig.advance(10);
      BOOST_TEST((result.outcome == StepOutcome::converged));
    }
    BOOST_TEST(result.left_out == 0);
    BOOST_TEST(std::hypot(result.contact_T_W.force.x, result.contact_T_W.force.y) < 0.01 * result.contact_T_W.force.z);
    at = depth;
    forces.push_back(result.contact_T_W.force.z);
  }
  return forces;
}

/// By how much each is above Hertz's, as a share.
std::vector<double> excess(int cells, Elasticity law = Elasticity::corotational,
                           ElementOrder order = ElementOrder::quadratic) {
  const std::vector<double> forces = press(cells, law, order);
  std::vector<double> shares;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    shares.push_back(forces[i] / hertz(depth_of_block(depths[i])) - 1);
    BOOST_TEST_MESSAGE(cells << " cells, depth " << depths[i] << ": " << forces[i] << " N, " << 100 * shares.back()
                             << " % above Hertz");
  }
  return shares;
}

}  // namespace

// Elements are stiffer than what they stand for, and the faces of the surface bridge the ball, so that the force comes
// down to Hertz's from above.
BOOST_AUTO_TEST_CASE(a_ball_is_pushed_as_hertz_says_the_nearer_the_finer_the_block) {
  const std::vector<double> coarse = excess(2), middle = excess(4);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    BOOST_TEST(coarse[i] < 0.3);
    BOOST_TEST(middle[i] < 0.12);
    BOOST_TEST(middle[i] < 0.5 * coarse[i]);
    BOOST_TEST(middle[i] > 0);
  }
  // Eigen's factorisation would take minutes.
  if (!has_suitesparse_plugin()) return;
  const std::vector<double> fine = excess(6);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    BOOST_TEST(fine[i] < 0.03);
    BOOST_TEST(fine[i] < middle[i]);
    BOOST_TEST(fine[i] > 0);
  }
}

BOOST_AUTO_TEST_CASE(a_small_strain_pushes_alike_by_both_laws) {
  const std::vector<double> one = excess(4), other = excess(4, Elasticity::neo_hookean);
  for (std::size_t i = 0; i < depths.size(); ++i) BOOST_TEST(std::abs(other[i] - one[i]) < 0.02);
}

BOOST_AUTO_TEST_CASE(linear_elements_are_stiffer_than_quadratic_ones_that_are_twice_as_long) {
  const std::vector<double> linear = excess(8, Elasticity::corotational, ElementOrder::linear), middle = excess(4);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    BOOST_TEST(linear[i] > middle[i]);
    BOOST_TEST(linear[i] < 0.2);
  }
}

BOOST_AUTO_TEST_SUITE_END()
