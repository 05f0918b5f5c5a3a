// The tetrahedra of deformable bodies: their boxes and surfaces, what is held, how stiff they are, and what is refused.
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>

#include <boost/test/unit_test.hpp>

#include "framework/core/value_error.hpp"
#include "nodes/physics/mesh/body_volume.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/cgal_plugin.hpp"
#include "tests/nodes/physics/mesh/volume_checks.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(body_volume_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

/// The cache of this test program alone.
struct Fixture {
  Fixture() { setenv("TACTOR_CACHE", cache.path().c_str(), 1); }
  TemporaryFolder cache;
};

Body soft_box(const Vec3& size, int tetrahedra = 1000) {
  Body body;
  body.name = "block";
  body.shape = BoxShape{size};
  body.motion = Motion::deformable;
  body.deformable.tetrahedra = tetrahedra;
  return body;
}

Body soft_mesh(const TriangleMesh& mesh, const std::string& name, int tetrahedra = 1000) {
  Body body = soft_box({}, tetrahedra);
  body.name = name;
  body.shape = MeshShape{test::write_off(mesh, name), 1.0};
  return body;
}

/// `PATH: message` of what is refused.
std::string refusal(const Body& body) {
  try {
    load_body_volume(body);
  } catch (const ValueError& e) {
    BOOST_TEST_MESSAGE(e.path() << ": " << e.what());
    return e.path() + ": " + e.what();
  }
  return "accepted";
}

bool has(const std::string& text, const std::string& phrase) {
  BOOST_TEST_INFO(text);
  return text.find(phrase) != std::string::npos;
}

bool has(const Notes& notes, const std::string& phrase) {
  return std::any_of(notes.begin(), notes.end(), [&](const std::string& n) { return n.find(phrase) != n.npos; });
}

}  // namespace

BOOST_GLOBAL_FIXTURE(Fixture);

BOOST_AUTO_TEST_CASE(a_box_is_filled_about_its_middle_and_told) {
  Notes notes;
  const BodyVolume volume = load_body_volume(soft_box({0.1, 0.06, 0.04}, 3000), &notes);
  test::check_sound(volume.mesh);
  BOOST_TEST(quality_of(volume.mesh).volume == 2.4e-4, tt::tolerance(1e-12));
  BOOST_TEST(norm(mass_properties(surface_of(volume.mesh)).center) < 1e-12);
  BOOST_TEST(std::abs(static_cast<double>(volume.mesh.tets.size()) / 3000 - 1) < 0.1);
  BOOST_TEST(volume.young.size() == volume.mesh.tets.size());
  BOOST_TEST((volume.fixed == std::vector<char>(volume.mesh.nodes.size(), 0)));
  BOOST_TEST_REQUIRE(notes.size() == 1U);
  const std::string count = std::to_string(volume.mesh.tets.size());
  BOOST_TEST(notes[0].starts_with("body 'block': " + count.substr(0, 1) + "," + count.substr(1) + " tetrahedra, "));
  BOOST_TEST(has(notes[0], " nodes, edges of "));
  load_body_volume(soft_box({0.1, 0.06, 0.04}, 3000), &notes);
  BOOST_TEST(notes.size() == 1U);
}

BOOST_AUTO_TEST_CASE(regions_hold_the_nodes_on_their_planes) {
  Body body = soft_box({0.1, 0.1, 0.1}, 0);
  body.deformable.cell_size = 0.025;
  body.deformable.fixed = {HalfSpaceRegion{{0, 0, -0.05}, {0, 0, 3}}};
  const auto count = [&] {
    const std::vector<char> fixed = load_body_volume(body).fixed;
    return std::count(fixed.begin(), fixed.end(), 1);
  };
  BOOST_TEST(count() == 25);
  body.deformable.fixed = {HalfSpaceRegion{{0, 0, 0}, {0, 0, -1}}};
  BOOST_TEST(count() == 75);
  body.deformable.fixed = {BoxRegion{{-0.05, -0.05, -0.05}, {-0.025, 0.05, -0.05}}};
  BOOST_TEST(count() == 10);
  body.deformable.fixed.push_back(HalfSpaceRegion{{0, 0, -0.05}, {0, 0, 1}});
  BOOST_TEST(count() == 25);
  const BodyVolume volume = load_body_volume(body);
  for (std::size_t i = 0; i < volume.fixed.size(); ++i) {
    BOOST_TEST((volume.fixed[i] == 1) == (volume.mesh.nodes[i].z == -0.05));
  }
}

BOOST_AUTO_TEST_CASE(tetrahedra_with_their_centroid_in_an_inclusion_have_its_stiffness) {
  Body body = soft_box({0.1, 0.1, 0.1}, 10000);
  body.deformable.young = 5e3;
  body.deformable.inclusions = {{{0.01, 0, 0}, 0.03, 5e4}, {{0.01, 0, 0}, 0.01, 1e6}};
  const BodyVolume volume = load_body_volume(body);
  double hard = 0, harder = 0, soft = 0;
  for (std::size_t t = 0; t < volume.mesh.tets.size(); ++t) {
    const double v = volume_of(corners_of(volume.mesh, volume.mesh.tets[t]));
    (volume.young[t] == 5e3 ? soft : volume.young[t] == 5e4 ? hard : harder) += v;
  }
  const auto ball = [](double r) { return 4.0 / 3 * std::numbers::pi * r * r * r; };
  BOOST_TEST(soft + hard + harder == 1e-3, tt::tolerance(1e-12));
  BOOST_TEST(hard + harder == ball(0.03), tt::tolerance(0.1));
  BOOST_TEST(harder == ball(0.01), tt::tolerance(0.5));
}

BOOST_AUTO_TEST_CASE(what_holds_nothing_is_refused_with_where_the_body_lies) {
  Body body = soft_box({0.1, 0.06, 0.04});
  body.deformable.fixed = {BoxRegion{{0, 0, 0.03}, {0.1, 0.1, 0.1}}};
  BOOST_TEST(has(refusal(body),
                 "scene.bodies.block.fixed: body 'block': the box between (0, 0, 0.03) and (0.1, 0.1, 0.1) holds no "
                 "node of it; the body lies between (-0.05, -0.03, -0.02) and (0.05, 0.03, 0.02) m"));
  body.deformable.fixed = {HalfSpaceRegion{{0, 0, 1}, {0, 0, 1}}};
  BOOST_TEST(has(refusal(body), "the regions hold all its nodes"));
  body.deformable.fixed = {NamedFaces{"bottom"}};
  BOOST_TEST(has(refusal(body),
                 "scene.bodies.block.fixed: body 'block': it has no faces named 'bottom'; its mesh names none"));
  body.deformable.fixed.clear();
  body.deformable.inclusions = {{{0, 0, 1}, 0.01, 1e5}};
  BOOST_TEST(has(refusal(body),
                 "scene.bodies.block.inclusions: body 'block': the ball of radius 10 mm about (0, 0, 1) contains no "
                 "centroid of a tetrahedron"));
}

BOOST_AUTO_TEST_CASE(shapes_and_sizes_that_cannot_be_filled_are_refused) {
  Body body = soft_box({0.1, 0.1, 0.1});
  body.shape = SphereShape{0.01};
  BOOST_TEST(has(refusal(body),
                 "scene.bodies.block.sphere: body 'block': a sphere is not filled with tetrahedra; a deformable "
                 "body is a mesh or a box"));
  body.shape = CapsuleShape{0.01, 0.1};
  BOOST_TEST(has(refusal(body), "scene.bodies.block.capsule: "));
  body.shape = PlaneShape{};
  BOOST_TEST(has(refusal(body), "scene.bodies.block.plane: "));
  body = soft_box({0.1, 0.1, 0.1}, 200'001);
  BOOST_TEST(
      has(refusal(body), "scene.bodies.block.tetrahedra: body 'block': 200001 tetrahedra; at most 200,000 are made"));
  body.deformable.cell_size = 0.0001;
  BOOST_TEST(
      has(refusal(body), "scene.bodies.block.cell_size: body 'block': cells of 0.1 mm are about 5e+09 tetrahedra"));
  body.deformable.cell_size = 1e-9;
  BOOST_TEST(has(refusal(body), "scene.bodies.block.cell_size: "));
  body.deformable.cell_size = 0;
  body.deformable.tetrahedra = 0;
  BOOST_TEST(has(refusal(body), "scene.bodies.block.tetrahedra: "));
}

BOOST_AUTO_TEST_CASE(a_surface_is_filled_in_its_own_frame_and_scale) {
  if (!has_cgal_plugin()) return;
  Body body = soft_mesh(test::box({20, 30, 40}, {100, 0, 0}), "brick");
  std::get<MeshShape>(body.shape).scale = 0.001;
  body.deformable.fixed = {HalfSpaceRegion{{0, 0, -0.02}, {0, 0, 1}}};
  Notes notes;
  const BodyVolume volume = load_body_volume(body, &notes);
  test::check_sound(volume.mesh);
  // Its edges are kept, so that its volume is exact.
  BOOST_TEST(quality_of(volume.mesh).volume == 2.4e-5, tt::tolerance(1e-6));
  const MassProperties mass = mass_properties(surface_of(volume.mesh));
  BOOST_TEST(norm(mass.center - Vec3{0.1, 0, 0}) < 1e-7);
  Bounds bounds;
  for (const Vec3& p : volume.mesh.nodes) bounds.add(p);
  BOOST_TEST(norm(bounds.low - Vec3{0.09, -0.015, -0.02}) < 1e-9);
  BOOST_TEST(norm(bounds.high - Vec3{0.11, 0.015, 0.02}) < 1e-9);
  for (std::size_t i = 0; i < volume.fixed.size(); ++i) {
    BOOST_TEST((volume.fixed[i] == 1) == (volume.mesh.nodes[i].z < -0.0199999));
  }
  BOOST_TEST(has(notes, "body 'brick': "));
  BOOST_TEST(has(notes, "volume 0.0 % "));
}

BOOST_AUTO_TEST_CASE(counts_and_edges_are_near_what_is_asked_for_and_the_volume_near_that_of_the_surface) {
  if (!has_cgal_plugin()) return;
  const TriangleMesh ball = test::icosphere(0.05, 4);
  const double ball_volume = mass_properties(ball).volume;
  for (const int wanted : {300, 1000, 3000, 10000}) {
    const BodyVolume volume = load_body_volume(soft_mesh(ball, "ball", wanted));
    test::check_sound(volume.mesh);
    const TetQuality quality = quality_of(volume.mesh);
    BOOST_TEST_CONTEXT(wanted << ": " << volume.mesh.tets.size() << ", "
                              << quality.smallest_angle * 180 / std::numbers::pi) {
      BOOST_TEST(std::abs(static_cast<double>(volume.mesh.tets.size()) / wanted - 1) < 0.1);
      BOOST_TEST(quality.volume < ball_volume);
      BOOST_TEST(quality.volume > (1 - 0.11 * std::pow(wanted / 300.0, -2.0 / 3)) * ball_volume);
      BOOST_TEST(quality.smallest_angle > 11 * std::numbers::pi / 180);
    }
    // Nodes of the boundary lie on the surface.
    double off = 0;
    for (const int i : surface_nodes(volume.mesh)) {
      off = std::max(off, std::abs(norm(volume.mesh.nodes[static_cast<std::size_t>(i)]) - 0.05));
    }
    BOOST_TEST(off < 0.0005);
  }
  Body body = soft_mesh(ball, "ball");
  body.deformable.cell_size = 0.01;
  BOOST_TEST(quality_of(load_body_volume(body).mesh).mean_edge == 0.01, tt::tolerance(0.1));
}

BOOST_AUTO_TEST_CASE(a_surface_that_is_no_solid_or_too_fine_is_refused) {
  if (!has_cgal_plugin()) return;
  TriangleMesh open = test::box({0.1, 0.1, 0.1});
  open.faces.pop_back();
  BOOST_TEST(has(refusal(soft_mesh(open, "open")), "scene.bodies.open.mesh: body 'open': "));
  BOOST_TEST(has(refusal(soft_mesh(open, "open")), "the surface is not closed"));
  // Thinner than its tetrahedra would be: they leave out most of it, or none comes about.
  BOOST_TEST(
      has(refusal(soft_mesh(test::box({0.2, 0.002, 0.002}), "needle", 300)), " % of its volume, and 75 % are needed"));
  BOOST_TEST(has(refusal(soft_mesh(test::box({0.1, 0.1, 0.001}), "sheet", 300)), "too thin or too sharp for so few"));
  Body body = soft_mesh(test::box({0.1, 0.1, 0.1}), "fine");
  body.deformable.cell_size = 0.0001;
  BOOST_TEST(has(refusal(body),
                 "scene.bodies.fine.cell_size: body 'fine': cells of 0.1 mm are about 8.49e+09 tetrahedra; at most "
                 "200,000 are made. 14.1 mm gives about 3,000"));
}

BOOST_AUTO_TEST_SUITE_END()
