// The grid of forces: what it reproduces, extrapolates, forgets and refuses.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>

#include "nodes/forcefield/force_grid.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(force_grid_test)

using namespace tactor;
using Known = ForceGrid::Known;

namespace {

constexpr double cell = 0.002;  // m
const Vec3 elsewhere{7, 7, 7};  // N, what is told where nothing is known

ForceGrid grid(double reach_cells, double forgetting = 1, std::int64_t nodes = 4096) {
  return ForceGrid({.cell = cell, .reach = reach_cells * cell, .forgetting = forgetting, .nodes = nodes});
}

Vec3 node(double i, double j, double k) {
  return cell * Vec3{i, j, k};
}

Vec3 linear_field(const Vec3& p) {
  return {1 + 300 * p.x - 20 * p.y, -2 + 100 * p.z, 50 * p.x + 10 * p.y - 400 * p.z};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_linear_field_felt_at_the_nodes_is_reproduced_between_them) {
  ForceGrid g = grid(0);
  for (int i = -3; i <= 3; ++i) {
    for (int j = -3; j <= 3; ++j) {
      for (int k = -3; k <= 3; ++k) BOOST_TEST(g.store(node(i, j, k), linear_field(node(i, j, k))));
    }
  }
  BOOST_TEST(g.stored() == 7 * 7 * 7);
  test::Dice dice(1);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 p = dice.in_cube(2.99 * cell);
    const ForceGrid::Look look = g.look(p, elsewhere);
    BOOST_TEST((look.known == Known::stored));
    BOOST_TEST(norm(look.force - linear_field(p)) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(what_is_felt_at_a_node_or_in_the_middle_of_a_cell_is_met) {
  for (const Vec3& p : {node(1, 1, 1), node(0.5, 0.5, 0.5), node(0.5, 0, 1)}) {
    ForceGrid g = grid(0);
    g.store(p, {1, 2, 3});
    g.store(p, {-4, 0, 1});
    BOOST_TEST(norm(g.look(p, elsewhere).force - Vec3{-4, 0, 1}) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(a_node_visited_again_forgets_a_share_of_what_it_was) {
  ForceGrid g = grid(0, 0.25);
  g.store(node(3, 0, 0), {4, 0, 0});
  for (int n = 1; n <= 20; ++n) {
    g.store(node(3, 0, 0), {0, 8, 0});
    const double left = std::pow(0.75, n);
    BOOST_TEST(norm(g.look(node(3, 0, 0), elsewhere).force - Vec3{4 * left, 8 * (1 - left), 0}) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(no_force_is_outside_of_those_that_were_felt_and_none_jumps_over_a_small_way) {
  for (const double reach : {0.0, 1.5, 3.0}) {
    ForceGrid g = grid(reach, 0.7);
    test::Dice dice(2);
    // A sample everywhere but in a corner, so that there is something to extrapolate and something to hold.
    for (int n = 0; n < 3000; ++n) {
      const Vec3 p = dice.in_cube(6 * cell);
      if (p.x + p.y + p.z < 0) g.store(p, dice.in_cube(3));
    }
    const Vec3 otherwise{3, -3, 3};
    // Between two nodes of a cell it changes by the difference of their forces, 6 N an axis at most.
    const double steepest = 6 * std::sqrt(3.0) * std::sqrt(3.0) / cell;
    constexpr double step = 1e-5;
    Vec3 last = g.look(node(-6, -6, -6), otherwise).force;
    int extrapolated = 0;
    for (double s = -6 * cell; s < 6 * cell; s += step) {
      const ForceGrid::Look look = g.look({s, s, s}, otherwise);
      for (int axis = 0; axis < 3; ++axis) BOOST_TEST(std::abs(look.force[axis]) <= 3 + 1e-12);
      if (s > -6 * cell) BOOST_TEST(norm(look.force - last) <= steepest * std::sqrt(3.0) * step);
      last = look.force;
      extrapolated += look.known == Known::extrapolated ? 1 : 0;
    }
    BOOST_TEST((extrapolated > 0) == (reach > 0));
  }
}

BOOST_AUTO_TEST_CASE(a_node_never_visited_has_the_forces_around_it_by_the_inverse_square_of_their_distance) {
  ForceGrid g = grid(2);
  g.store(node(1, 0, 0), {1, 0, 0});
  g.store(node(-2, 0, 0), {0, 1, 0});
  g.store(node(0, 0, 3), {0, 0, 50});  // out of reach
  const ForceGrid::Look look = g.look(node(0, 0, 0), elsewhere);
  BOOST_TEST((look.known == Known::extrapolated));
  BOOST_TEST(norm(look.force - Vec3{1 / 1.25, 0.25 / 1.25, 0}) < 1e-12);
  // Half-way to the stored node.
  BOOST_TEST(norm(g.look(node(0.5, 0, 0), elsewhere).force - Vec3{0.9, 0.1, 0}) < 1e-12);
}

BOOST_AUTO_TEST_CASE(where_nothing_is_within_reach_nothing_is_known) {
  ForceGrid g = grid(2);
  BOOST_TEST((g.look({}, elsewhere).known == Known::nothing));
  BOOST_TEST(norm(g.look({}, elsewhere).force - elsewhere) == 0.0);
  g.store({}, {1, 0, 0});
  BOOST_TEST((g.look(node(2, 0, 0), elsewhere).known == Known::extrapolated));
  BOOST_TEST((g.look(node(3, 0, 0), elsewhere).known == Known::nothing));
  BOOST_TEST(norm(g.look(node(3, 0, 0), elsewhere).force - elsewhere) == 0.0);
}

BOOST_AUTO_TEST_CASE(a_full_table_takes_what_is_new_and_forgets_what_is_old) {
  for (const std::int64_t nodes : {8, 60, 1000}) {
    ForceGrid g = grid(0, 1, nodes);
    BOOST_TEST(g.capacity() >= nodes);
    BOOST_TEST(g.capacity() < 2 * nodes + 8);
    BOOST_TEST(g.memory_bytes() == static_cast<std::size_t>(g.capacity()) * 40);
    constexpr int visits = 5000;
    for (int n = 0; n < visits; ++n) {
      const Vec3 p = node(2 * n + 0.5, 0.5, 0.5);  // eight new nodes each
      g.store(p, {static_cast<double>(n), 0, 0});
      BOOST_TEST((g.look(p, elsewhere).known == Known::stored));
      BOOST_TEST(g.look(p, elsewhere).force.x == n);
      BOOST_TEST(g.stored() <= g.capacity());
      BOOST_TEST(g.stored() + g.evicted() == 8 * (n + 1));
    }
    BOOST_TEST(g.evicted() > 0);
    BOOST_TEST((g.look(node(0.5, 0.5, 0.5), elsewhere).known == Known::nothing));
  }
}

BOOST_AUTO_TEST_CASE(a_position_that_is_none_is_refused) {
  ForceGrid g = grid(2);
  g.store({}, {1, 0, 0});
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), inf, -inf, 1e300, 2e6 * cell, -2e6 * cell}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 p;
      p[axis] = bad;
      BOOST_TEST(!g.store(p, {5, 0, 0}));
      BOOST_TEST((g.look(p, elsewhere).known == Known::nothing));
    }
  }
  BOOST_TEST(g.stored() == 1);
  BOOST_TEST(g.look({}, elsewhere).force.x == 1.0);
  // Nodes as far away as they may be keep apart.
  const double far = std::floor(1048000.0) * cell;
  BOOST_TEST(g.store({far, far, -far}, {2, 0, 0}));
  BOOST_TEST(g.store({-far, far, -far}, {3, 0, 0}));
  BOOST_TEST(g.look({far, far, -far}, elsewhere).force.x == 2.0);
  BOOST_TEST(g.look({-far, far, -far}, elsewhere).force.x == 3.0);
}

BOOST_AUTO_TEST_SUITE_END()
