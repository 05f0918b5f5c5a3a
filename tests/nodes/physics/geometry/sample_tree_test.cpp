// What the tree of samples finds against a look at every sample, whatever was asked before.
#include <boost/test/unit_test.hpp>

#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/geometry/cell_distance.hpp"
#include "nodes/physics/geometry/sample_tree.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(sample_tree_test)

using namespace tactor;

namespace {

/// An icosphere with spikes and dents: sharp convex and concave features.
TriangleMesh spiky(int levels) {
  TriangleMesh mesh = test::icosphere(0.05, levels);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] *= i % 3 == 0 ? 1.5 : i % 3 == 1 ? 0.7 : 1.0;
  return mesh;
}

/// Counts the questions that reach a field.
class Counted final : public SignedDistance {
 public:
  explicit Counted(const SignedDistance& field) : field_(field) {}
  [[nodiscard]] Nearest nearest(const Vec3& x, int hint) const override {
    ++exact;
    return field_.nearest(x, hint);
  }
  void lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const override {
    ++bounds;
    field_.lower_bounds(x, wanted, bound);
  }
  [[nodiscard]] Eigen::Matrix3d hessian(const Nearest& nearest, const Vec3& x) const override {
    return field_.hessian(nearest, x);
  }
  mutable int exact = 0, bounds = 0;

 private:
  const SignedDistance& field_;
};

std::vector<int> sorted_samples(const std::vector<NearSample>& found) {
  std::vector<int> samples;
  for (const NearSample& n : found) samples.push_back(n.sample);
  std::sort(samples.begin(), samples.end());
  return samples;
}

/// A walk of mostly small steps with a few jumps, that stays near the other body.
struct Walk {
  test::Dice dice{7};
  Vec3 p{0.1, 0, 0}, r;
  Pose next(int step) {
    const double reach = step % 40 == 0 ? 0.03 : step % 3 == 0 ? 1e-5 : 5e-4;
    p = (step % 40 == 0 ? 0.9 : 0.9995) * p + dice.in_cube(reach);
    r += dice.in_cube(10 * reach);
    return {p, from_rotation_vector(r)};
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(the_tree_finds_what_a_look_at_every_sample_finds_whatever_came_before) {
  const TriangleMesh body = spiky(3);
  const ExactDistance exact(body);
  const CellDistance cells(body, {.resolution = 48, .band = 0.004});
  const std::vector<SurfaceSample> samples = vertex_samples(test::icosphere(0.04, 3)).points;
  SampleTree by_cells(samples), by_search(samples);
  Walk walk;
  const double margin = 0.002;
  std::size_t total = 0;
  for (int step = 0; step < 300; ++step) {
    const Pose X = walk.next(step);
    const std::vector<NearSample>& found = by_cells.find(cells, X, margin);
    std::vector<int> by_force;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (exact.nearest(transform(X, samples[i].p)).distance < margin) by_force.push_back(static_cast<int>(i));
    }
    BOOST_TEST(sorted_samples(found) == by_force, boost::test_tools::per_element());
    for (const NearSample& n : found) {
      BOOST_TEST((n.nearest == exact.nearest(transform(X, samples[static_cast<std::size_t>(n.sample)].p))));
      BOOST_TEST(n.distance == n.nearest.distance);
    }
    SampleTree fresh(samples);
    BOOST_TEST((fresh.find(cells, X, margin) == found));
    BOOST_TEST((by_search.find(exact, X, margin) == found));
    total += found.size();
  }
  BOOST_TEST(total > 3000U);
}

BOOST_AUTO_TEST_CASE(a_search_that_may_not_do_all_its_work_ends_and_spoils_no_later_one) {
  const TriangleMesh body = spiky(3);
  const CellDistance cells(body, {.resolution = 48, .band = 0.004});
  const Counted counted(cells);
  const std::vector<SurfaceSample> samples = vertex_samples(test::icosphere(0.04, 3)).points;
  SampleTree tree(samples);
  Walk walk;
  int ended = 0, all_written = 0, written_whole = 0;
  for (int step = 0; step < 400; ++step) {
    const Pose X = walk.next(step);
    const int most = step % 3 == 0 ? 5 : 60;
    int left = most;
    counted.exact = counted.bounds = 0;
    tree.find(counted, X, 0.002, &left);
    // After a long way all nodes of the tree were written: 81 above the 642 samples, 11 above these, 2 and the root.
    constexpr int writing = 12;
    const int more = most - left - (counted.exact + counted.bounds);
    BOOST_TEST((more == 0 || more == writing || (left == -1 && more > 0 && more < writing)));
    all_written += more > 0 ? 1 : 0;
    written_whole += more == writing ? 1 : 0;
    BOOST_TEST(left >= -1);
    ended += left < 0 ? 1 : 0;
    if (step % 4 != 0) continue;
    // At the same place or a little on, with all the work it needs.
    SampleTree fresh(samples);
    BOOST_TEST((tree.find(cells, X, 0.002) == fresh.find(cells, X, 0.002)));
  }
  BOOST_TEST(all_written > 3);
  BOOST_TEST(all_written < 40);
  BOOST_TEST(written_whole > 0);
  BOOST_TEST(ended > 100);
  BOOST_TEST(ended < 400);
}

BOOST_AUTO_TEST_CASE(long_ways_lose_nothing) {
  const ExactDistance field(test::box({0.06, 0.06, 0.06}));
  const std::vector<SurfaceSample> samples = sample_surface(test::box({0.02, 0.02, 0.02}), 0.005).points;
  SampleTree tree(samples);
  std::size_t total = 0;
  // 40 m and 300 rad in steps of 4 mm and 0.03 rad.
  for (int step = 0; step < 10000; ++step) {
    const double a = 0.1 * step;
    const Pose X{{0.0405 * std::cos(a), 0.0405 * std::sin(a), 0}, from_rotation_vector({0, 0, 0.13 * a})};
    const std::vector<NearSample>& found = tree.find(field, X, 0.0005);
    total += found.size();
    if (step % 7 != 0) continue;
    SampleTree fresh(samples);
    BOOST_REQUIRE((fresh.find(field, X, 0.0005) == found));
  }
  BOOST_TEST(total > 10000U);
}

BOOST_AUTO_TEST_CASE(spheres_about_the_samples_touch_by_their_radius) {
  const TriangleMesh body = test::icosphere(0.05, 3);
  const ExactDistance field(body);
  const std::vector<SurfaceSample> samples = vertex_samples(test::icosphere(0.04, 2)).points;
  std::vector<double> radii;
  for (std::size_t i = 0; i < samples.size(); ++i) radii.push_back(1e-4 * static_cast<double>(i % 50));
  SampleTree tree(samples, radii);
  Walk walk;
  std::size_t total = 0;
  for (int step = 0; step < 200; ++step) {
    const Pose X = walk.next(step);
    const std::vector<NearSample>& found = tree.find(field, X, 0.001);
    std::vector<int> by_force;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (field.nearest(transform(X, samples[i].p)).distance - radii[i] < 0.001)
        by_force.push_back(static_cast<int>(i));
    }
    BOOST_TEST(sorted_samples(found) == by_force, boost::test_tools::per_element());
    for (const NearSample& n : found) {
      BOOST_TEST(n.distance == n.nearest.distance - radii[static_cast<std::size_t>(n.sample)]);
    }
    total += found.size();
  }
  BOOST_TEST(total > 1000U);
}

BOOST_AUTO_TEST_CASE(a_margin_may_change_between_queries) {
  const ExactDistance field(test::icosphere(0.05, 3));
  const std::vector<SurfaceSample> samples = vertex_samples(test::icosphere(0.04, 3)).points;
  SampleTree tree(samples);
  const Pose X{{0.0898, 0, 0}, {}};
  std::size_t last = 0;
  for (const double margin : {0.0, 0.001, 0.004, 0.002, 0.0}) {
    SampleTree fresh(samples);
    const std::vector<NearSample>& found = tree.find(field, X, margin);
    BOOST_TEST((fresh.find(field, X, margin) == found));
    BOOST_TEST(found.size() != last);
    last = found.size();
  }
}

BOOST_AUTO_TEST_CASE(a_query_at_the_same_pose_asks_nothing_and_a_small_step_asks_little) {
  const ExactDistance ball(test::icosphere(0.05, 3));
  const Counted field(ball);
  const std::vector<SurfaceSample> samples = vertex_samples(test::icosphere(0.04, 4)).points;
  SampleTree tree(samples);
  Pose X{{0.0895, 0, 0}, {}};
  const std::vector<NearSample> first = tree.find(field, X, 0);
  BOOST_TEST(first.size() > 5U);
  field.exact = field.bounds = 0;
  BOOST_TEST((tree.find(field, X, 0) == first));
  BOOST_TEST(field.exact + field.bounds == 0);
  X.p.y += 1e-6;
  const std::size_t found = tree.find(field, X, 0).size();
  BOOST_TEST(field.exact <= static_cast<int>(found) + 8);
  BOOST_TEST(field.bounds <= static_cast<int>(found) + 8);
}

BOOST_AUTO_TEST_CASE(no_samples_find_nothing) {
  const ExactDistance field(test::box({1, 1, 1}));
  SampleTree none({});
  BOOST_TEST(none.find(field, {}, 0.1).empty());
  SampleTree one({{{0.1, 0, 0}, 1}});
  BOOST_TEST(one.find(field, {}, 0.1).size() == 1U);
  BOOST_TEST(one.find(field, {{2, 0, 0}, {}}, 0.1).empty());
}

BOOST_AUTO_TEST_SUITE_END()
