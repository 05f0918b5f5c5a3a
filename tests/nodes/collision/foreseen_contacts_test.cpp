// Contacts beyond the margin that a motion is about to make: where closed forms put them, none where the way is free,
// and what they are for: a fast body gets no energy from a surface.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <memory>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/collision/exact_distance.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/collision/sample_tree.hpp"
#include "nodes/collision/sdf.hpp"
#include "tests/nodes/collision/scenes.hpp"
#include "tests/nodes/dice.hpp"

using namespace tactor;

namespace {

constexpr double margin = 0.002, period = 0.02;  // m, s
constexpr double ahead = default_look_ahead * period;

template <class N>
std::unique_ptr<N> made(const Scene& scene) {
  return std::make_unique<N>(test::default_params<N>(), test::context_for(scene));
}

BodyStates at(const Pose& X_WT, const Vec3& v, const Vec3& w = {}) {
  BodyStates bodies;
  bodies.count = 1;
  bodies.X_WB[0] = X_WT;
  bodies.V_WB[0] = {v, w};
  return bodies;
}

TriangleMesh rock(double radius, int levels) {
  TriangleMesh mesh = test::icosphere(radius, levels);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] *= i % 3 == 0 ? 1.1 : i % 3 == 1 ? 0.93 : 1.0;
  return mesh;
}

bool same(const ContactSet& a, const ContactSet& b) {
  if (a.count != b.count || a.truncated != b.truncated) return false;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i) {
    const Contact &c = a.contact[i], &d = b.contact[i];
    if (!(c.p_TC == d.p_TC && c.p_WC == d.p_WC && c.n_W == d.n_W && c.distance == d.distance && c.weight == d.weight &&
          c.H_W == d.H_W)) {
      return false;
    }
  }
  return true;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_ball_meets_a_ball_where_the_ray_meets_the_sphere_of_both_radii) {
  constexpr double tool = 0.01, fixed = 0.05;
  Scene scene;
  scene.bodies = {test::ball("fixed", fixed), test::ball("tool", tool, Motion::translation)};
  const auto node = made<PrimitiveCollision>(scene);
  test::Dice dice(11);
  int touching = 0, passing = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = dice.in_cube(0.3), v = dice.in_cube(3) - 6 / norm(p) * p;
    const double clear = norm(p) - tool - fixed;
    if (clear < margin || norm(v) * ahead < margin) continue;
    // |p + t v| = both radii.
    const double reach = tool + fixed, a = dot(v, v), b = dot(p, v), c = dot(p, p) - reach * reach;
    const double root = b * b - a * c;
    const bool hits = root >= 0 && -b - std::sqrt(root) > 0 && (-b - std::sqrt(root)) / a < ahead;
    // Where the way ends at the surface, or passes by less than a ten-thousandth of it, either is right.
    const double nearest = std::sqrt(std::max(0.0, dot(p, p) - b * b / a)) - reach, way = norm(v) * ahead;
    const double end = norm(p + ahead * v) - reach;
    if (std::abs(nearest) < 2e-4 * way || std::abs(end) < 2e-4 * way) continue;
    // Nor where it comes in so flat that it is given up: the last hundredth of the ball.
    if (hits && nearest > -0.01 * reach) continue;
    ContactSet set;
    node->query(at({p, {}}, v), period, set);
    BOOST_TEST_CONTEXT("way " << i) {
      BOOST_TEST_REQUIRE(set.count == (hits ? 1 : 0));
    }
    (hits ? touching : passing) += 1;
    if (!hits) continue;
    BOOST_TEST(set.penetrating == 0);
    const Vec3 x = p + (-b - std::sqrt(root)) / a * v, n = x / norm(x);
    const Contact& found = set.contact[0];
    // It stops short of the surface by up to a ten-thousandth of the way, at a sine of incidence of at least 0.14.
    const double off = 1e-4 * way / 0.14;
    BOOST_TEST(norm(found.n_W - n) < 2 * off / reach);
    BOOST_TEST(norm(found.p_WC - fixed * n) < 2 * off);
    BOOST_TEST(std::abs(found.distance - dot(found.n_W, p - tool * found.n_W - found.p_WC)) < 1e-12);
    BOOST_TEST((found.H_W == std::array<double, 6>{}));
  }
  BOOST_TEST(touching > 100);
  BOOST_TEST(passing > 500);
}

BOOST_AUTO_TEST_CASE(a_body_that_flies_past_a_corner_without_touching_has_no_contact) {
  // A rock past the corner of a block, by twice the margin, at 10 m/s: from every place on its way, and on every side.
  const TriangleMesh flying = rock(0.02, 2);
  double lowest = 0;
  for (const Vec3& v : flying.vertices) lowest = std::min(lowest, v.z);
  Scene scene;
  scene.bodies = {test::mesh_body("block", test::box({0.1, 0.1, 0.1})), test::mesh_body("tool", flying, Motion::rigid)};
  const auto node = made<SdfCollision>(scene);
  const double height = 0.05 - lowest + 2 * margin;
  for (double x = -0.5; x <= 0.5; x += 0.01) {
    ContactSet set;
    node->query(at({{x, 0.048, height}, {}}, {10, 0, 0}), period, set);
    BOOST_TEST(set.count == 0);
    // Lower by 4 mm more than what is clear, it hits the side of the block, until it is over it or past it.
    node->query(at({{x, 0.048, height - 2 * margin - 0.004}, {}}, {10, 0, 0}), period, set);
    if (x > -0.4 && x < -0.08) BOOST_TEST(set.count > 0);
    if (x > 0.08) BOOST_TEST(set.count == 0);
  }
}

BOOST_AUTO_TEST_CASE(the_tree_foresees_what_a_way_of_each_sample_does) {
  const ExactDistance field(rock(0.05, 3));
  const TriangleMesh moving = test::icosphere(0.03, 3);
  const std::vector<SurfaceSample> samples = vertex_samples(moving);
  SampleTree tree(samples);
  test::Dice dice(11);
  std::size_t total = 0, cut = 0, apart = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose now{0.12 / std::sqrt(3.0) * Vec3{1, 1, 1} + dice.in_cube(0.02), from_rotation_vector(dice.in_cube(1))};
    const Pose then{0.3 * now.p + dice.in_cube(0.05), from_rotation_vector(dice.in_cube(0.25)) * now.R};
    tree.find(field, now, margin);
    std::vector<std::pair<int, double>> one_by_one;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const Vec3 from = transform(now, samples[k].p);
      if (field.nearest(from).distance < margin) continue;
      StraightWay on{from, transform(then, samples[k].p) - from};
      if (first_touch(field, on)) one_by_one.emplace_back(static_cast<int>(k), on.share);
    }
    const std::vector<ForeseenSample>& found = tree.foresee(field, now, then, samples.size());
    // The order of looks and where they begin differ, so a way that grazes may be given up by one alone.
    std::size_t common = 0;
    for (const ForeseenSample& f : found) {
      const auto other =
          std::find_if(one_by_one.begin(), one_by_one.end(), [&](const auto& o) { return o.first == f.at.sample; });
      if (other == one_by_one.end()) continue;
      ++common;
      // Where a way grazes something before it, the one may stop there and the other not.
      const double way = norm(transform(then, samples[static_cast<std::size_t>(f.at.sample)].p) -
                              transform(now, samples[static_cast<std::size_t>(f.at.sample)].p));
      // Both stop within the tolerance of the surface; flat ways differ by more along it.
      if (-dot(f.at.nearest.gradient, then.p - now.p) > 0.3 * norm(then.p - now.p)) {
        apart += std::abs(other->second - f.share) * way > 1e-3 * way ? 1 : 0;
      }
    }
    BOOST_TEST(common + 3 >= one_by_one.size());
    BOOST_TEST(common + 3 >= found.size());
    total += common;
    // Of fewer than there are, those that touch first.
    if (found.size() <= 20) continue;
    ++cut;
    std::vector<double> shares;
    for (const ForeseenSample& f : found) shares.push_back(f.share);
    std::sort(shares.begin(), shares.end());
    const std::vector<ForeseenSample>& first = tree.foresee(field, now, then, 10);
    BOOST_TEST(first.size() == 10U);
    for (const ForeseenSample& f : first) BOOST_TEST(f.share <= shares[9] + 1e-3);
  }
  BOOST_TEST(total > 1000U);
  BOOST_TEST(cut > 10U);
  BOOST_TEST(apart <= total / 200);
}

BOOST_AUTO_TEST_CASE(where_bodies_move_by_less_than_the_margin_velocities_do_not_count) {
  Scene scene;
  scene.bodies = {test::mesh_body("rock", rock(0.05, 3)), test::mesh_body("tool", rock(0.03, 2), Motion::rigid)};
  const auto still = made<SdfCollision>(scene), slow = made<SdfCollision>(scene), fast = made<SdfCollision>(scene);
  test::Dice dice(11);
  int more = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose X_WT{0.08 / std::sqrt(3.0) * Vec3{1, 1, 1} + dice.in_cube(0.006), from_rotation_vector(dice.in_cube(1))};
    const Vec3 direction = dice.in_cube(1) - 2.0 * X_WT.p / norm(X_WT.p);
    // The way is that of the origin and of a turn about it, at most 33 mm.
    const Vec3 v = 0.5 * margin / ahead / norm(direction) * direction;
    const Vec3 w = 0.25 * margin / ahead / 0.033 * Vec3{0.6, 0.8, 0};
    ContactSet a, b, c;
    still->query(X_WT, a);
    slow->query(at(X_WT, v, w), period, b);
    fast->query(at(X_WT, 100 * v, w), period, c);
    BOOST_TEST(same(a, b));
    BOOST_TEST(c.penetrating == a.penetrating);
    more += c.count > a.count ? 1 : 0;
  }
  BOOST_TEST(more > 100);
}

BOOST_AUTO_TEST_CASE(a_wall_of_foreseen_contacts_carries_as_much_as_the_surface_that_will_be_met) {
  // A block that falls flat onto another: foreseen from afar or found on touching, about the same stiffness:
  // what the samples of either side stand for at the edges differs, and so do the shares of the sides.
  Scene scene;
  scene.bodies = {test::shaped("floor", BoxShape{{0.04, 0.04, 0.04}}),
                  test::shaped("tool", BoxShape{{0.04, 0.04, 0.04}}, Motion::rigid)};
  auto params = test::default_params<PrimitiveCollision>();
  params.spacing = 0.01;
  const auto node = std::make_unique<PrimitiveCollision>(params, test::context_for(scene));
  // Of the faces that meet, not of the samples above and below them, which would touch later.
  const auto stiffness_down = [](const ContactSet& set) {
    double sum = 0;
    for (const Contact& c : test::contacts_of(set)) {
      if (c.distance < test::deepest(set, 1) + 1e-6) sum += c.weight * c.stiffness * c.n_W.z;
    }
    return sum;
  };
  ContactSet touching, afar;
  node->query({{0.0001, 0.0002, 0.0399}, {}}, touching);
  node->query(at({{0.0001, 0.0002, 0.14}, {}}, {0, 0, -10}), period, afar);
  BOOST_TEST(afar.penetrating == 0);
  BOOST_TEST(touching.truncated == 0);
  BOOST_TEST(stiffness_down(touching) > 0);
  BOOST_TEST(stiffness_down(afar) == stiffness_down(touching), boost::test_tools::tolerance(0.35));
  BOOST_TEST(std::abs(test::deepest(afar, 1) - 0.1) < 1e-9);
}

BOOST_AUTO_TEST_CASE(looking_ahead_allocates_nothing_once_it_has_met_the_most_contacts) {
  if (!heap_calls_are_counted()) return;
  Scene scene;
  scene.bodies = {test::mesh_body("rock", rock(0.05, 3)), test::mesh_body("tool", rock(0.03, 2), Motion::rigid)};
  const auto node = made<SdfCollision>(scene);
  const auto set = std::make_unique<ContactSet>();
  std::int64_t before = 0;
  int found = 0;
  for (int round = 0; round < 2; ++round) {
    before = thread_heap_calls();
    for (int i = 0; i < 50; ++i) {
      node->query(at({{0.2 - 0.002 * i, 0.01, 0}, {}}, {-10, 0, 0.1 * i}, {0, 1, 2}), period, *set);
      found += set->count;
    }
  }
  BOOST_TEST(found > 1000);
  BOOST_TEST(thread_heap_calls() == before);
}
