// The samples of shapes: their number, weights and areas, and how far the depth they find falls short.
#include <boost/test/unit_test.hpp>

#include <numeric>

#include "framework/core/check.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/physics/contact/contact_samples.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"

BOOST_AUTO_TEST_SUITE(contact_samples_test)

using namespace tactor;
namespace tt = boost::test_tools;

BOOST_AUTO_TEST_CASE(a_sphere_is_one_ball_of_weight_1_and_a_plane_has_no_samples) {
  const ContactSamples sphere = shape_samples(SphereShape{0.02}, 0.001);
  BOOST_REQUIRE(sphere.points.size() == 1U);
  BOOST_TEST(norm(sphere.points[0].p) == 0.0);
  BOOST_TEST(sphere.radii.at(0) == 0.02);
  BOOST_TEST(sphere.weights.at(0) == 1.0);
  BOOST_TEST(shape_samples(PlaneShape{}, 0).points.empty());
  BOOST_CHECK_THROW(shape_samples(MeshShape{}, 0), InputError);
}

BOOST_AUTO_TEST_CASE(a_capsule_weighs_the_same_whatever_the_spacing) {
  const CapsuleShape capsule{.radius = 0.005, .length = 0.04};
  for (const double spacing : {0.0, 0.1, 0.02, 0.003, 0.0001}) {
    const ContactSamples samples = shape_samples(capsule, spacing);
    BOOST_TEST(std::accumulate(samples.weights.begin(), samples.weights.end(), 0.0) == 2 + 0.04 / 0.01,
               tt::tolerance(1e-12));
    BOOST_TEST(samples.weights.front() == 1.0);
    BOOST_TEST(samples.weights.back() == 1.0);
    BOOST_TEST(samples.points.front().p.z == -0.02);
    BOOST_TEST(samples.points.back().p.z == 0.02);
    BOOST_TEST(samples.points.size() >= 3U);
    const double most = spacing > 0 ? spacing : default_spacing(capsule);
    for (std::size_t i = 1; i < samples.points.size() && samples.points.size() > 3; ++i) {
      BOOST_TEST(samples.points[i].p.z - samples.points[i - 1].p.z <= most * (1 + 1e-9));
      BOOST_TEST(samples.radii[i] == 0.005);
    }
  }
  BOOST_CHECK_THROW(shape_samples(capsule, 1e-9), InputError);
}

BOOST_AUTO_TEST_CASE(the_areas_of_a_box_sum_to_its_surface_and_favour_no_direction) {
  const BoxShape box{{0.04, 0.02, 0.01}};
  for (const double spacing : {0.0, 1.0, 0.003, 0.001}) {
    const ContactSamples samples = shape_samples(box, spacing);
    double area = 0;
    Vec3 first;
    for (const SurfaceSample& s : samples.points) {
      area += s.area;
      first += s.area * s.p;
      const double beyond = std::max({std::abs(s.p.x) - 0.02, std::abs(s.p.y) - 0.01, std::abs(s.p.z) - 0.005});
      BOOST_TEST(std::abs(beyond) < 1e-15);
    }
    BOOST_TEST(area == 2 * (0.04 * 0.02 + 0.02 * 0.01 + 0.01 * 0.04), tt::tolerance(1e-12));
    BOOST_TEST(norm(first) < 1e-15);
  }
  BOOST_TEST(shape_samples(box, 1.0).points.size() == 8U);
  // Eight parts along the longest edge, four and two along the others: all points of the lattice less those inside.
  BOOST_TEST(shape_samples(box, 0).points.size() == static_cast<std::size_t>(9 * 5 * 3 - 7 * 3 * 1));
}

BOOST_AUTO_TEST_CASE(a_capsule_falls_short_of_a_spike_by_no_more_than_its_bound) {
  // The tip of a needle, all along the capsule: between the samples it is found too shallow.
  TriangleMesh needle = test::box({0.02, 0.02, 0.02}, {0, 0, -0.01});
  for (const std::size_t i : {4U, 5U, 6U, 7U}) {
    needle.vertices[i] = {1e-7 * needle.vertices[i].x, 1e-7 * needle.vertices[i].y, 0.01};
  }
  for (auto& v : needle.vertices) v.z -= 0.01;
  const double r = 0.005;
  Scene scene;
  scene.bodies = {test::mesh_body("needle", needle), test::shaped("tool", CapsuleShape{r, 0.04}, Motion::rigid)};
  auto params = test::default_params<PrimitiveCollision>();
  for (const double spacing : {0.0, 0.004}) {
    params.spacing = spacing;
    PrimitiveCollision node(params, test::context_for(scene));
    const double s = spacing > 0 ? spacing : default_spacing(scene.bodies[1].shape);
    for (const double depth : {0.0001, 0.001, 0.002}) {
      const double d = r - depth, bound = std::sqrt(d * d + s * s / 4) - d;
      double worst = 0;
      for (int i = 0; i <= 200; ++i) {
        ContactSet set;
        // Across the needle, its tip below the axis at a place of the segment that the loop moves.
        node.query({{1e-4 * i - 0.01, 0, d}, from_rotation_vector({0, std::numbers::pi / 2, 0})}, set);
        const double error = test::deepest(set, params.margin) + depth;
        // The tip is a square of 2 nm.
        BOOST_TEST(error >= -1e-8);
        worst = std::max(worst, error);
      }
      BOOST_TEST(worst <= bound + 1e-8);
      BOOST_TEST(worst >= 0.9 * bound);
    }
  }
  BOOST_TEST(default_spacing(CapsuleShape{r, 0.04}) * default_spacing(CapsuleShape{r, 0.04}) / (8 * r) == 0.01 * r,
             tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(a_small_box_on_a_large_one_is_pushed_off_it_alike_wherever_it_lies) {
  // A tool of 24 x 16 x 12 mm, 1 mm deep in a wall of 300 mm whose own eighth would be 37.5 mm.
  constexpr double depth = 1e-3;
  Scene scene;
  scene.bodies = {test::shaped("wall", BoxShape{{0.02, 0.3, 0.3}}),
                  test::shaped("tool", BoxShape{{0.024, 0.016, 0.012}}, Motion::rigid)};
  PrimitiveCollision node(test::default_params<PrimitiveCollision>(), test::context_for(scene));
  double least = 1e9, most = 0, sideways = 0;
  for (int i = 0; i <= 400; ++i) {
    ContactSet set;
    node.query({{0.01 + 0.012 - depth, 1e-4 * i, 0.37e-4 * i}, {}}, set);
    const Wrench push = test::spring_wrench(set);
    least = std::min(least, push.force.x);
    most = std::max(most, push.force.x);
    sideways = std::max(sideways, std::hypot(push.force.y, push.force.z));
  }
  // Its face has 1.92 patches, of 1000 N/m each. Samples of the wall that lie nearer to a side of the tool than the
  // tool is deep face away from that side, and push nothing.
  const double area_pushes = 1.92;
  BOOST_TEST(least > 0.99 * area_pushes);
  BOOST_TEST(most < 1.01 * area_pushes);
  BOOST_TEST(sideways < 1e-3 * area_pushes);
}

BOOST_AUTO_TEST_SUITE_END()
