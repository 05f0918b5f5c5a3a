// The tree of a tool's samples: what it knows from earlier searches changes nothing that it finds.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>

#include "nodes/physics/contact/soft_samples.hpp"
#include "tests/nodes/physics/contact/soft_scenes.hpp"

BOOST_AUTO_TEST_SUITE(soft_samples_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double margin = 0.002;  // m

std::vector<SurfaceSample> samples_of(const TriangleMesh& mesh, double spacing) {
  return sample_surface(mesh, spacing).points;
}

bool same(const std::vector<NearSoftSample>& a, const std::vector<NearSoftSample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const NearSoftSample& p, const NearSoftSample& q) {
    return p.sample == q.sample && p.at.face == q.at.face && p.at.distance == q.at.distance && p.at.p == q.at.p;
  });
}

/// A slow way with leaps, and a surface that waves.
struct Wandering {
  Dice& dice;
  Pose X_WB;
  double wave = 0;  // m
  void go_on(int round) {
    const bool leaps = round % 37 == 0;
    const double by = leaps ? 0.02 : 2e-4;
    X_WB.p += dice.in_cube(by);
    X_WB.p = {std::clamp(X_WB.p.x, -0.02, 0.02), std::clamp(X_WB.p.y, -0.02, 0.02), std::clamp(X_WB.p.z, -0.02, 0.05)};
    X_WB.R = normalized(from_rotation_vector(dice.in_cube(leaps ? 1 : 0.01)) * X_WB.R);
    wave += 1e-4 * dice(-1, 1);
  }
};

/// A box of samples, and a flat grid that it is searched on.
struct BoxOverGrid {
  SoftSampleTree tree{samples_of(box({0.03, 0.02, 0.02}), 0.002)};
  SoftMesh soft = soft_mesh(flat_grid(0.06, 13));
  MovingSurface surface;
  SoftSampleMemory memory = tree.new_memory();
  std::vector<NearSoftSample> found;
  BoxOverGrid() { surface.set(soft.surface.faces, soft.nodes); }
  /// The steps of work with the box at z, m.
  int find(double z) {
    int left = 1'000'000;
    tree.find(surface, {{0, 0, z}, {}}, margin, &left, memory, found);
    return 1'000'000 - left;
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(what_was_looked_at_before_changes_nothing_that_is_found) {
  Dice dice(5);
  const SoftSampleTree tree(samples_of(box({0.03, 0.02, 0.02}), 0.002));
  std::size_t found_in_all = 0;
  for (const TriangleMesh& mesh : {icosphere(0.03, 3), flat_grid(0.06, 13)}) {
    const SoftMesh soft = soft_mesh(mesh);
    MovingSurface surface;
    surface.set(soft.surface.faces, soft.nodes);
    SoftSampleMemory memory = tree.new_memory();
    Wandering motion{dice, {{0, 0, 0.04}, {}}};
    std::vector<Vec3> nodes = soft.nodes;
    std::vector<NearSoftSample> known, fresh;
    for (int round = 1; round < 600; ++round) {
      motion.go_on(round);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        nodes[i] =
            soft.nodes[i] + motion.wave * Vec3{std::sin(90 * soft.nodes[i].y), 0, std::cos(70 * soft.nodes[i].x)};
      }
      surface.move(nodes);
      // Another surface now and then.
      if (round % 101 == 0) {
        const std::span all(soft.surface.faces);
        surface.set(round % 2 == 0 ? all : all.first(all.size() / 2), nodes);
      }
      tree.find(surface, motion.X_WB, margin, nullptr, memory, known);
      SoftSampleMemory none = tree.new_memory();
      tree.find(surface, motion.X_WB, margin, nullptr, none, fresh);
      BOOST_TEST(same(known, fresh));
      found_in_all += fresh.size();
    }
  }
  BOOST_TEST(found_in_all > 10000U);
}

BOOST_AUTO_TEST_CASE(what_hardly_moved_is_hardly_looked_at) {
  BoxOverGrid scene;
  const int first = scene.find(0.0135), second = scene.find(0.01351);
  BOOST_TEST(first > 0);
  BOOST_TEST(second < first / 2);
}

BOOST_AUTO_TEST_CASE(nodes_that_are_no_numbers_are_never_taken_for_known) {
  BoxOverGrid scene;
  scene.find(0.05);
  BOOST_TEST(scene.found.empty());
  // Nowhere for a while, looked at or not, and then back where the samples are.
  for (const bool look : {false, true}) {
    std::vector<Vec3> nodes(scene.soft.nodes.size(), Vec3{std::nan(""), 0, 0});
    scene.surface.move(nodes);
    if (look) scene.find(0.05);
    BOOST_TEST(scene.found.empty());
    nodes = scene.soft.nodes;
    for (Vec3& p : nodes) p.z = 0.045;
    scene.surface.move(nodes);
    scene.find(0.05);
    BOOST_TEST(!scene.found.empty());
    scene.found.clear();
  }
  // A node that was none for a moment costs nothing later on.
  std::vector<Vec3> nodes = scene.soft.nodes;
  const auto work = [&] {
    scene.surface.move(nodes);
    return scene.find(0.0135);
  };
  nodes[0].x = std::nan("");
  work();
  nodes[0] = scene.soft.nodes[0];
  const int first = work(), second = work();
  BOOST_TEST(second < first);
}

BOOST_AUTO_TEST_SUITE_END()
