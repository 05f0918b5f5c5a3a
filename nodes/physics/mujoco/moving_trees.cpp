#include "nodes/physics/mujoco/moving_trees.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "nodes/physics/mujoco/conversions.hpp"

namespace tactor {

namespace {

/// m/s^2, by which the hand may speed up.
constexpr double hand_acceleration = 10;

/// s of CPU time of a step with so many degrees of freedom, geoms, and pairs of geoms that may touch. Measured on heaps
/// of 6, 25 and 60 spheres, boxes and capsules, with MuJoCo 2.2.2 on one core of a server: right by a factor of two.
double cost_of(double dofs, double geoms, double pairs) {
  return 2e-6 + 0.15e-6 * geoms + 0.4e-6 * dofs + 3.5e-6 * pairs;
}

constexpr Trees bit(int tree) {
  return Trees{1} << tree;
}

/// The representative of a set of roots.
int found(std::vector<int>& joined, int body) {
  while (joined[static_cast<std::size_t>(body)] != body) body = joined[static_cast<std::size_t>(body)];
  return body;
}

/// A body that an object of the model lies on: 0 where there is none.
int body_of_wrap(const mjModel& m, int wrap) {
  const int object = m.wrap_objid[wrap];
  if (object < 0) return 0;
  switch (m.wrap_type[wrap]) {
    case mjWRAP_JOINT:
      return m.jnt_bodyid[object];
    case mjWRAP_SITE:
      return m.site_bodyid[object];
    case mjWRAP_SPHERE:
    case mjWRAP_CYLINDER:
      return m.geom_bodyid[object];
    default:
      return 0;
  }
}

int body_of_equality(const mjModel& m, int equality, int object) {
  if (object < 0) return 0;
  switch (m.eq_type[equality]) {
    case mjEQ_CONNECT:
    case mjEQ_WELD:
      return object;
    case mjEQ_JOINT:
      return m.jnt_bodyid[object];
    default:
      return 0;
  }
}

}  // namespace

/// By number of a body: the child of the world whose tree its own is a part of; -1 where nothing moves.
std::vector<int> MovingTrees::joined_roots(const mjModel& m, int tool) {
  std::vector<char> moves(static_cast<std::size_t>(m.nbody), 0);
  for (int b = 1; b < m.nbody; ++b) {
    if (m.body_dofnum[b] > 0) moves[static_cast<std::size_t>(m.body_rootid[b])] = 1;
  }
  std::vector<int> joined(static_cast<std::size_t>(m.nbody));
  std::iota(joined.begin(), joined.end(), 0);
  const auto join = [&](int a, int b) {
    const int first = m.body_rootid[a], second = m.body_rootid[b];
    if (moves[static_cast<std::size_t>(first)] == 0 || moves[static_cast<std::size_t>(second)] == 0) return;
    joined[static_cast<std::size_t>(found(joined, first))] = found(joined, second);
  };
  for (int i = 0; i < m.neq; ++i) {
    join(body_of_equality(m, i, m.eq_obj1id[i]), body_of_equality(m, i, m.eq_obj2id[i]));
  }
  for (int i = 0; i < m.nexclude; ++i) {
    join((m.exclude_signature[i] >> 16) - 1, (m.exclude_signature[i] & 0xFFFF) - 1);
  }
  for (int i = 0; i < m.nwrap; ++i) join(tool, body_of_wrap(m, i));
  for (int i = 0; i < m.nu; ++i) {
    const int type = m.actuator_trntype[i], object = m.actuator_trnid[2 * i], other = m.actuator_trnid[2 * i + 1];
    if (type == mjTRN_BODY) join(tool, object);
    if (type != mjTRN_SITE && type != mjTRN_SLIDERCRANK) continue;
    join(tool, m.site_bodyid[object]);
    if (other >= 0) join(tool, m.site_bodyid[other]);
  }
  for (int b = 0; b < m.nbody; ++b) {
    const int root = m.body_rootid[b];
    joined[static_cast<std::size_t>(b)] = b != root ? joined[static_cast<std::size_t>(root)]
                                          : moves[static_cast<std::size_t>(b)] != 0 ? found(joined, b)
                                                                                    : -1;
  }
  return joined;
}

MovingTrees::MovingTrees(const mjModel& whole, int tool)
    : whole_(&whole), of_body_(static_cast<std::size_t>(whole.nbody), -1) {
  const std::vector<int> roots = joined_roots(whole, tool);
  std::vector<int> order{roots[static_cast<std::size_t>(tool)]};
  for (int b = 0; b < whole.nbody; ++b) {
    const int root = roots[static_cast<std::size_t>(b)];
    if (root < 0) {
      ++fixed_bodies_;
      continue;
    }
    const auto place = std::find(order.begin(), order.end(), root);
    of_body_[static_cast<std::size_t>(b)] = static_cast<int>(place - order.begin());
    if (place == order.end()) order.push_back(root);
  }
  geoms_.resize(order.size());
  bodies_.resize(order.size());
  dofs_.resize(order.size());
  for (int b = 0; b < whole.nbody; ++b) {
    const int tree = of_body(b);
    if (tree < 0) continue;
    ++bodies_[static_cast<std::size_t>(tree)];
    dofs_[static_cast<std::size_t>(tree)] += whole.body_dofnum[b];
  }
  for (int g = 0; g < whole.ngeom; ++g) {
    const int body = whole.geom_bodyid[g], tree = of_body(body);
    if (tree >= 0) geoms_[static_cast<std::size_t>(tree)].push_back(g);
    if (whole.body_rootid[body] == tool) of_tool_.push_back(g);
  }
  if (whole.npair > 0) why_whole_ = "the model names pairs of geoms in <contact>, so all of its bodies move in it";
  if (count() > most_trees) {
    why_whole_ = "the model has " + std::to_string(count()) + " trees, and a rollout chooses among at most " +
                 std::to_string(most_trees);
  }
}

bool MovingTrees::stands(int body, Trees moving) const {
  const int tree = of_body(body);
  return tree >= 0 && (moving & bit(tree)) == 0;
}

bool MovingTrees::any_stands(Trees moving) const {
  if (!why_whole_.empty()) return false;
  const Trees mine = count() == most_trees ? all_trees : bit(count()) - 1;
  return (moving & mine) != mine;
}

int MovingTrees::bodies(Trees moving) const {
  if (!any_stands(moving)) return whole_->nbody;
  int sum = fixed_bodies_ + 1;
  for (int t = 0; t < count(); ++t) {
    if ((moving & bit(t)) != 0) sum += bodies_[static_cast<std::size_t>(t)];
  }
  return sum;
}

double MovingTrees::step_cost(const mjData& placed, Trees moving) const {
  const bool all = !any_stands(moving);
  int dofs = 0, pairs = 0;
  for (int t = 0; t < std::min(count(), most_trees); ++t) {
    if (!all && (moving & bit(t)) == 0) continue;
    dofs += dofs_[static_cast<std::size_t>(t)];
    pairs += pairs_of(placed, t, moving & (bit(t) - 1));
  }
  return cost_of(dofs, whole_->ngeom, pairs);
}

/// Pairs of a geom of the tree and one of another tree, whose spheres meet; without the trees that are `counted`.
int MovingTrees::pairs_of(const mjData& placed, int tree, Trees counted) const {
  int pairs = 0;
  for (int other = 0; other < std::min(count(), most_trees); ++other) {
    if (other == tree || (counted & bit(other)) != 0) continue;
    for (const int a : geoms_[static_cast<std::size_t>(tree)]) {
      for (const int b : geoms_[static_cast<std::size_t>(other)]) pairs += gap(placed, a, b) <= 0 ? 1 : 0;
    }
  }
  return pairs;
}

/// m, between the spheres around two geoms; negative where they meet.
double MovingTrees::gap(const mjData& placed, int a, int b) const {
  return norm(vec3_at(placed.geom_xpos + 3 * a) - vec3_at(placed.geom_xpos + 3 * b)) - whole_->geom_rbound[a] -
         whole_->geom_rbound[b];
}

/// The least of all pairs.
double MovingTrees::gap(const mjData& placed, std::span<const int> first, std::span<const int> second) const {
  double least = std::numeric_limits<double>::infinity();
  for (const int a : first) {
    for (const int b : second) least = std::min(least, gap(placed, a, b));
  }
  return least;
}

/// m/s, of the fastest point of the geoms.
double MovingTrees::speed(const mjData& placed, std::span<const int> geoms) const {
  double most = 0;
  for (const int geom : geoms) {
    double turn_and_move[6];
    mj_objectVelocity(whole_, &placed, mjOBJ_GEOM, geom, turn_and_move, 0);
    most = std::max(most, norm(vec3_at(turn_and_move + 3)) + whole_->geom_rbound[geom] * norm(vec3_at(turn_and_move)));
  }
  return most;
}

Trees MovingTrees::near(const mjData& placed, const TreeSearch& search, int most_bodies) const {
  if (!why_whole_.empty()) return all_trees;
  const double T = search.horizon;
  const double hand = search.handle_speed + hand_acceleration * T;
  const double by_hand = search.stretch + std::max(hand, speed(placed, of_tool_)) * T;
  // m: to the tool, how far each goes by itself, and how far it may be pushed.
  std::array<double, most_trees> to_tool{}, own{}, pushed{};
  Trees within_reach = 0, moving = bit(0);
  pushed[0] = by_hand;
  for (int t = 1; t < count(); ++t) {
    const auto i = static_cast<std::size_t>(t);
    to_tool[i] = gap(placed, of_tool_, geoms_[i]);
    own[i] = speed(placed, geoms_[i]) * T;
    pushed[i] = std::max(by_hand, own[i]);
  }
  const auto note_reached_by = [&](int mover) {
    const auto m = static_cast<std::size_t>(mover);
    for (int t = 1; t < count(); ++t) {
      const auto i = static_cast<std::size_t>(t);
      if (((moving | within_reach) & bit(t)) != 0) continue;
      if (gap(placed, geoms_[m], geoms_[i]) <= pushed[m] + own[i]) within_reach |= bit(t);
    }
  };
  for (int newest = 0;;) {
    note_reached_by(newest);
    int next = -1;
    for (int t = 1; t < count(); ++t) {
      if ((within_reach & bit(t)) == 0) continue;
      if (next < 0 || to_tool[static_cast<std::size_t>(t)] < to_tool[static_cast<std::size_t>(next)]) next = t;
    }
    if (next < 0) return moving;
    const Trees more = moving | bit(next);
    if (bodies(more) > most_bodies || step_cost(placed, more) > search.step_budget) return moving;
    moving = more;
    within_reach &= ~bit(next);
    newest = next;
  }
}

}  // namespace tactor
