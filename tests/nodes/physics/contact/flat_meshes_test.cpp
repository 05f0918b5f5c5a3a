// A flat mesh pushes as the box does that has its faces, whatever its triangles: against boxes and closed forms.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nodes/physics/contact/scene_contacts.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"
#include "tests/nodes/physics/contact/flat_meshes.hpp"

BOOST_AUTO_TEST_SUITE(flat_meshes_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double k = 1000 / 1e-4;  // N/m^3, of two bodies of 2000 N/m a patch in series
constexpr double coupling = 274;   // N/m, of the hand's spring

MakeMeshDistance distance(int how) {
  const CellOptions cells{.resolution = 24, .band = 0.002};
  return how % 8 != 0 ? tree_distances() : cell_distances(cells, nullptr);
}

/// A tool on a plate, which is a mesh in one scene and a box in the other.
struct Pair {
  Pair(int member, double tilt) : dice(static_cast<std::uint64_t>(member)) {
    const int tool_kind = member / test::triangulations % 3, triangles = member % test::triangulations;
    size = {dice(0.03, 0.3), dice(0.03, 0.3), dice(0.005, 0.03)};
    tool = test::flat_tool(tool_kind, dice, "tool" + std::to_string(member));
    name = std::string(test::triangulation_name(triangles)) + " under " + tool.name;
    // The pair lies as it likes in the world.
    if (dice(0, 1) < 0.7) X_WP = dice.pose(0.3, 3);
    X_PT.R = from_rotation_vector({tilt * dice(-1, 1), tilt * dice(-1, 1), 0}) *
             from_rotation_vector({0, 0, dice(0, 1) < 0.3 ? 0 : dice(-3, 3)});
    tool.body.motion = dice(0, 1) < 0.5 ? Motion::translation : Motion::rigid;
    tool.body.X_WB = X_WP * Pose{{0, 0, 1}, X_PT.R};
    const Body mesh = test::mesh_body("plate" + std::to_string(member), test::triangulated_box(size, triangles, dice));
    const MakeMeshDistance how = distance(member);
    by_mesh = std::make_unique<SceneContacts>(scene_with(mesh), options, how);
    by_box = std::make_unique<SceneContacts>(scene_with(test::shaped("plate", BoxShape{size})), options, how);
    double low = 0;
    for (const Vec3& v : corners()) low = std::min(low, rotate(X_PT.R, v).z);
    // As deep as a hand presses that leads the tool so far in.
    depth = coupling * dice(5e-4, 2.5e-3) / (coupling + k * tool.area);
    X_PT.p.z = size.z / 2 - low - depth;
  }
  [[nodiscard]] Scene scene_with(Body plate) const {
    plate.X_WB = X_WP;
    plate.material.friction = 0;
    Scene scene;
    scene.bodies = {std::move(plate), tool.body};
    return scene;
  }
  [[nodiscard]] std::vector<Vec3> corners() const {
    if (const auto* box = std::get_if<BoxShape>(&tool.body.shape)) return test::box(box->size).vertices;
    return load_body_mesh(tool.body).vertices;
  }
  /// Puts the tool somewhere on the plate, all of its foot on it. False where the plate has no room.
  bool move() {
    const double x = size.x / 2 - tool.reach - 0.002, y = size.y / 2 - tool.reach - 0.002;
    if (x < 0 || y < 0) return false;
    X_PT.p.x = dice(-x, x);
    X_PT.p.y = dice(-y, y);
    return true;
  }
  /// N, in the frame of the plate.
  Vec3 push(SceneContacts& contacts) const {
    BodyStates bodies;
    bodies.count = 1;
    bodies.X_WB[0] = X_WP * X_PT;
    ContactSet set;
    contacts.find(bodies, set);
    return rotate(inverse(X_WP.R), test::spring_wrench(set).force);
  }

  test::Dice dice;
  ContactOptions options{.margin = 0.002};
  Vec3 size;
  test::FlatTool tool;
  std::string name;
  Pose X_WP, X_PT;
  double depth = 0;  // m
  std::unique_ptr<SceneContacts> by_mesh, by_box;
};

double sideways(const Vec3& force) {
  return std::hypot(force.x, force.y);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_mesh_of_a_plate_pushes_as_the_box_does_whatever_its_triangles) {
  int compared = 0;
  for (int member = 0; member < 4 * 3 * test::triangulations; ++member) {
    Pair pair(member, 0);
    BOOST_TEST_CONTEXT("member " << member << ", " << pair.name) {
      for (int place = 0; place < 5 && pair.move(); ++place, ++compared) {
        const Vec3 mesh = pair.push(*pair.by_mesh), box = pair.push(*pair.by_box);
        BOOST_TEST(sideways(mesh) < 0.02);
        BOOST_TEST(mesh.z == box.z, tt::tolerance(0.03));
        // The sides of a stamp lean over the plate and push too.
        if (pair.tool.name.find("stamp") == std::string::npos) {
          BOOST_TEST(mesh.z == k * pair.tool.area * pair.depth, tt::tolerance(0.03));
        }
      }
    }
  }
  BOOST_TEST(compared > 500);
}

BOOST_AUTO_TEST_CASE(a_tool_that_is_tilted_on_a_plate_is_pushed_straight_up) {
  for (int member = 0; member < 3 * test::triangulations; ++member) {
    Pair pair(1000 + member, 0.06);
    BOOST_TEST_CONTEXT("member " << member << ", " << pair.name) {
      for (int place = 0; place < 4 && pair.move(); ++place) {
        const Vec3 mesh = pair.push(*pair.by_mesh);
        BOOST_TEST(mesh.z > 0);
        const double box = pair.push(*pair.by_box).z;
        BOOST_TEST(std::abs(mesh.z - box) < 0.03 * box + 0.001);
        BOOST_TEST(sideways(mesh) < 0.02);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_force_of_a_flat_mesh_changes_little_by_little_as_a_tool_slides_over_it) {
  for (const int member : {1, 12, 22}) {
    Pair pair(member, 0);
    if (!pair.move()) continue;
    const double way = 0.01;
    double largest = 0, most = 0;
    Vec3 last;
    for (int i = 0; i <= 1000; ++i) {
      pair.X_PT.p.x = pair.size.x / 2 - pair.tool.reach - 0.002 - way * i / 1000;
      const Vec3 now = pair.push(*pair.by_mesh);
      if (i > 0) largest = std::max(largest, norm(now - last));
      most = std::max(most, norm(now));
      last = now;
    }
    BOOST_TEST(largest < 0.01 * most, pair.name << ": " << largest << " N of " << most << " N");
  }
}

BOOST_AUTO_TEST_CASE(a_sample_counts_as_far_as_it_faces_what_it_meets) {
  const ContactSamples samples = shape_samples(BoxShape{{0.04, 0.04, 0.04}}, 0.01);
  const double cell = 1e-4;
  int faces = 0, edges = 0, corners = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Vec3& p = samples.points[i].p;
    const auto outer = [](double x) { return std::abs(x) > 0.0199; };
    if (!outer(p.z) || p.z < 0) continue;
    if (!outer(p.x) && !outer(p.y)) {
      // On the upper face: the area as seen from there.
      for (const double turn : {0.0, 0.3, 1.0, 1.5}) {
        BOOST_TEST(area_facing(samples, i, {std::sin(turn), 0, std::cos(turn)}) == cell * std::cos(turn),
                   tt::tolerance(1e-12));
      }
      BOOST_TEST(area_facing(samples, i, {1, 0, 0}) == 0.0);
      BOOST_TEST(area_facing(samples, i, {0, 0, -1}) == 0.0);
      ++faces;
    } else if (outer(p.x) != outer(p.y)) {
      // Of an edge the face counts that lies on the other body, and neither where that is met along the edge.
      BOOST_TEST(area_facing(samples, i, {0, 0, 1}) == cell / 2, tt::tolerance(0.002));
      BOOST_TEST(area_facing(samples, i, outer(p.x) ? Vec3{0, 1, 0} : Vec3{1, 0, 0}) == 0.0);
      ++edges;
    } else {
      BOOST_TEST(area_facing(samples, i, p / norm(p)) == 0.75 * cell, tt::tolerance(1e-9));
      BOOST_TEST(area_facing(samples, i, -p / norm(p)) == 0.0);
      ++corners;
    }
  }
  BOOST_TEST(faces == 9);
  BOOST_TEST(edges == 12);
  BOOST_TEST(corners == 4);
}

BOOST_AUTO_TEST_SUITE_END()
