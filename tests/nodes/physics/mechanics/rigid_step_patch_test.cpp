// Steps of rigid bodies with a patch of a deforming surface: against closed forms of one contact, against all active
// sets of a few, and against the step without a patch.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <optional>

#include <Eigen/LU>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/mechanics/eigen.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"
#include "tests/nodes/physics/mechanics/patches.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(rigid_step_patch_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double h = 0.004;  // s

/// A patch with its memory.
struct Nodes {
  std::vector<Vec3> p;
  Eigen::MatrixXd inertia;
  Eigen::VectorXd velocity, free;
  std::vector<SoftContact> contacts;
  Eigen::VectorXd after, force;

  explicit Nodes(int n) : p(static_cast<std::size_t>(n)) {
    inertia = Eigen::MatrixXd::Identity(3 * n, 3 * n);
    velocity = free = after = force = Eigen::VectorXd::Zero(3 * n);
  }
  StepResult step(RigidStep& rigid, const CouplingParameters& coupling, const DeviceState& device, BodyStates& bodies,
                  const ContactPlanes& planes = {}) {
    const BodyStates query = bodies;
    const SoftPatch patch{.p_W = p,
                          .inertia = inertia,
                          .velocity = velocity,
                          .free_velocity = free,
                          .contacts = contacts,
                          .query_p_W = p,
                          .query_X_WB = std::span(query.X_WB).first(static_cast<std::size_t>(query.count))};
    return rigid.advance(patch, coupling, device, device, planes, h, bodies, {after, force});
  }
};

SoftContact touch(double distance, double k, double b, double mu, const std::array<std::int32_t, 3>& node = {0, -1, -1},
                  const std::array<double, 3>& share = {1, 0, 0}) {
  SoftContact c;
  c.contact = floor_at({0, 0, 0}, distance, k, b, mu);
  c.body = 0;
  c.node = node;
  c.share = share;
  return c;
}

SystemModel tool_of(double mass, Integrator integrator = Integrator::implicit_euler) {
  SystemModel model = block(mass);
  model.gravity_W = {};
  model.integrator = integrator;
  model.tolerance = 1e-13;
  return model;
}

}  // namespace

BOOST_AUTO_TEST_CASE(one_contact_with_one_node_is_two_masses_and_a_spring) {
  constexpr double m = 0.05, m2 = 0.003, k = 1500, b = 1.5;
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const double phi : {-0.002, -1e-4, 1e-4, 0.002}) {
      Nodes nodes(1);
      nodes.inertia *= m2;
      nodes.velocity[2] = 0.02;
      nodes.free[2] = 0.07;
      nodes.contacts = {touch(phi, k, b, 0)};
      BodyStates bodies;
      bodies.count = 1;
      bodies.V_WB[0].v = {0.01, 0, -0.15};
      RigidStep rigid(tool_of(m, integrator), 1);
      const StepResult result = nodes.step(rigid, {}, {}, bodies);
      BOOST_TEST((result.outcome == StepOutcome::converged));
      const bool midpoint = integrator == Integrator::midpoint;
      const double s = midpoint ? h / 2 : h, slope = k * s + b, u = -0.15 - 0.07, w = 1 / m + 1 / m2;
      const double N = (-k * phi - slope * u) / (1 + s * slope * w);
      // By the midpoint rule the closed form is that of a contact that lasts.
      const double end = -k * phi - 2 * s * k * (u + s * N * w);
      if (midpoint && !(phi < 0 && end > 0)) continue;
      const double expected = std::max(0.0, N);
      BOOST_TEST_CONTEXT("midpoint " << midpoint << ", distance " << phi) {
        BOOST_TEST(std::abs(nodes.force[2] + expected) < 1e-9);
        BOOST_TEST(std::abs(nodes.after[2] - (0.07 - s * expected / m2)) < 1e-9);
        const double mean = -0.15 + s * expected / m;
        BOOST_TEST(std::abs(bodies.V_WB[0].v.z - (midpoint ? 2 * mean + 0.15 : mean)) < 1e-9);
        BOOST_TEST(std::abs(bodies.X_WB[0].p.z - h * mean) < 1e-12);
        if (!midpoint) BOOST_TEST(std::abs(result.contact_T_W.force.z - expected) < 1e-9);
        BOOST_TEST(std::abs(bodies.V_WB[0].v.x - 0.01) < 1e-12);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(friction_with_a_node_slides_by_coulomb_and_sticks_below) {
  constexpr double m = 0.05, m2 = 0.003, k = 1500, mu = 0.3;
  const double w = 1 / m + 1 / m2, phi = -0.002;
  const double N = -k * phi / (1 + h * k * h * w);
  const double carried = h * mu * N * w;  // m/s, what friction takes from the sliding speed at most
  for (const double speed : {0.5 * carried, 0.95 * carried, 1.2 * carried, 5 * carried}) {
    Nodes nodes(1);
    nodes.inertia *= m2;
    nodes.contacts = {touch(phi, k, 0, mu)};
    BodyStates bodies;
    bodies.count = 1;
    bodies.V_WB[0].v = {speed, 0, 0};
    const SystemModel model = tool_of(m);
    RigidStep rigid(model, 1);
    BOOST_TEST((nodes.step(rigid, {}, {}, bodies).outcome == StepOutcome::converged));
    const double left = bodies.V_WB[0].v.x - nodes.after[0];
    if (speed > carried) {
      BOOST_TEST(left == speed - carried, tt::tolerance(1e-3));
      BOOST_TEST(nodes.force[0] == mu * N, tt::tolerance(1e-3));
    } else {
      BOOST_TEST(std::abs(left) < model.stick_velocity);
      BOOST_TEST(nodes.force[0] < mu * N);
    }
    // What the node gets the tool loses.
    BOOST_TEST(m * bodies.V_WB[0].v.x + m2 * nodes.after[0] == m * speed, tt::tolerance(1e-9));
  }
}

namespace {

/// A tool that turns, a second body that does not, and six contacts of the tool, the second body and a fixed one with
/// five nodes, two contacts on faces with fixed nodes.
struct Heap {
  static constexpr int nodes_count = 5, dofs = 9 + 3 * nodes_count;
  Nodes nodes{nodes_count};
  BodyStates bodies;
  SystemModel model;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(dofs, dofs);
  Eigen::VectorXd free = Eigen::VectorXd::Zero(dofs);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, dofs);
  Eigen::VectorXd push = Eigen::VectorXd::Zero(6), slope = Eigen::VectorXd::Zero(6);

  explicit Heap(unsigned seed) {
    Dice dice(seed);
    const RandomPatch random(nodes_count, static_cast<int>(seed));
    model = tool_of(0.05);
    model.count = 2;
    model.body[0].rotates = true;
    model.body[0].inertia_B = 4e-6 * Eigen::Matrix3d::Identity();
    model.body[1].mass = 0.08;
    model.body[1].rotates = false;
    bodies.count = 2;
    bodies.X_WB[0] = {dice.in_cube(0.02), from_rotation_vector(dice.in_cube(1))};
    bodies.X_WB[1].p = dice.in_cube(0.02);
    bodies.V_WB[0].v = dice.in_cube(0.2);
    bodies.V_WB[1].v = dice.in_cube(0.2);
    nodes.inertia = random.M;
    nodes.free = random.u;
    nodes.velocity = 0.5 * random.u;
    for (int i = 0; i < nodes_count; ++i) nodes.p[static_cast<std::size_t>(i)] = random.p(i);
    A.diagonal() << Eigen::Vector3d::Constant(0.05), Eigen::Vector3d::Constant(4e-6), Eigen::Vector3d::Constant(0.08),
        Eigen::VectorXd::Zero(3 * nodes_count);
    A.bottomRightCorner(3 * nodes_count, 3 * nodes_count) = random.M;
    free << eigen(bodies.V_WB[0].v), Eigen::Vector3d::Zero(), eigen(bodies.V_WB[1].v), random.u;
    const std::array<std::array<std::int32_t, 3>, 6> faces{
        {{0, 1, 2}, {2, 1, 3}, {3, 4, -1}, {-1, -1, 4}, {1, 4, 0}, {2, 3, 4}}};
    for (int i = 0; i < 6; ++i) {
      SoftContact c;
      c.body = i < 4 ? 0 : i == 4 ? 1 : ContactPair::fixed;
      c.node = faces[static_cast<std::size_t>(i)];
      c.share = {0.2, 0.5, 0.3};
      const double k = 800, b = 0.7, weight = 0.5;
      c.contact = floor_at(dice.in_cube(0.008), dice(-0.0015, 0.0008), k, b, 0);
      c.contact.weight = weight;
      c.contact.n_W = rotate(from_rotation_vector(dice.in_cube(1)), {0, 0, 1});
      nodes.contacts.push_back(c);
      const Eigen::RowVector3d n = eigen(c.contact.n_W).transpose();
      if (c.body == 0) {
        J.block<1, 3>(i, 0) = n;
        const Vec3 lever = rotate(bodies.X_WB[0].R, c.contact.p_TC);
        J.block<1, 3>(i, 3) = eigen(cross(lever, c.contact.n_W)).transpose();
      } else if (c.body == 1) {
        J.block<1, 3>(i, 6) = n;
      }
      for (std::size_t l = 0; l < 3; ++l) {
        if (c.node[l] >= 0) J.block<1, 3>(i, 9 + 3 * c.node[l]) -= c.share[l] * n;
      }
      push[i] = -k * weight * c.contact.distance;
      slope[i] = h * k * weight + b * weight;
    }
  }
  /// The velocities with N_i = max(0, push_i - slope_i (J v)_i), by trying which contacts push: just one choice agrees
  /// with itself.
  [[nodiscard]] std::optional<Eigen::VectorXd> solve(Eigen::VectorXd& N) const {
    for (unsigned set = 0; set < 64; ++set) {
      Eigen::MatrixXd H = A;
      Eigen::VectorXd right = A * free;
      for (int i = 0; i < 6; ++i) {
        if ((set >> static_cast<unsigned>(i) & 1U) == 0) continue;
        H += h * slope[i] * J.row(i).transpose() * J.row(i);
        right += h * push[i] * J.row(i).transpose();
      }
      const Eigen::VectorXd v = H.partialPivLu().solve(right);
      N = push - slope.cwiseProduct(J * v);
      bool agrees = true;
      for (int i = 0; i < 6; ++i) agrees = agrees && ((set >> static_cast<unsigned>(i) & 1U) == 1) == (N[i] > 0);
      if (agrees) return v;
    }
    return std::nullopt;
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(several_bodies_and_nodes_go_as_the_one_set_of_contacts_that_agrees_with_itself) {
  int apart = 0, pushing = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Heap heap(seed);
    Eigen::VectorXd N;
    const std::optional<Eigen::VectorXd> v = heap.solve(N);
    BOOST_REQUIRE(v.has_value());
    RigidStep rigid(heap.model, Heap::nodes_count);
    const StepResult result = heap.nodes.step(rigid, {}, {}, heap.bodies);
    BOOST_TEST((result.outcome == StepOutcome::converged));
    const double size = v->norm();
    BOOST_TEST((eigen(heap.bodies.V_WB[0].v) - v->segment<3>(0)).norm() < 1e-8 * size);
    BOOST_TEST((eigen(heap.bodies.V_WB[1].v) - v->segment<3>(6)).norm() < 1e-8 * size);
    BOOST_TEST((eigen(heap.bodies.V_WB[0].w) - v->segment<3>(3)).norm() < 1e-7 * size);
    BOOST_TEST((heap.nodes.after - v->tail(3 * Heap::nodes_count)).norm() < 1e-8 * size);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * Heap::nodes_count);
    Eigen::Vector3d on_tool = Eigen::Vector3d::Zero();
    for (int i = 0; i < 6; ++i) {
      force += std::max(0.0, N[i]) * heap.J.row(i).tail(3 * Heap::nodes_count).transpose();
      on_tool += std::max(0.0, N[i]) * heap.J.row(i).head<3>().transpose();
      (N[i] > 0 ? pushing : apart) += 1;
    }
    BOOST_TEST((heap.nodes.force - force).norm() < 1e-7 * (1 + force.norm()));
    BOOST_TEST((eigen(result.contact_T_W.force) - on_tool).norm() < 1e-7 * (1 + on_tool.norm()));
  }
  // Both kinds were met.
  BOOST_TEST(apart > 40);
  BOOST_TEST(pushing > 40);
}

BOOST_AUTO_TEST_CASE(against_an_enormous_inertia_or_fixed_nodes_the_step_is_that_without_a_patch) {
  constexpr double m = 0.05;
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const bool fixed : {false, true}) {
      for (const bool none : {false, true}) {
        if (none && !fixed) continue;
        Nodes nodes(none ? 0 : 3);
        nodes.inertia *= 1e9;
        const std::array<std::int32_t, 3> face =
            fixed ? std::array<std::int32_t, 3>{-1, -1, -1} : std::array<std::int32_t, 3>{0, 1, 2};
        nodes.contacts = {touch(-0.001, 1500, 2, 0.3, face, {0.3, 0.3, 0.4})};
        BodyStates soft, plain;
        soft.count = plain.count = 1;
        soft.V_WB[0].v = plain.V_WB[0].v = {0.1, 0.02, -0.2};
        const CouplingParameters coupling{.k_t = 400, .b_t = 5, .force_max = 8, .torque_max = 1};
        DeviceState device;
        device.X_WD.p = {0.001, 0, -0.002};
        RigidStep with(tool_of(m, integrator), 3), without(tool_of(m, integrator));
        for (int i = 0; i < 20; ++i) {
          BOOST_TEST((nodes.step(with, coupling, device, soft).outcome == StepOutcome::converged));
          const Pose query = plain.X_WB[0];
          const ContactPair pair;
          without.advance(coupling, device, device, {{&query, 1}, {&nodes.contacts[0].contact, 1}, {&pair, 1}}, h,
                          plain);
          BOOST_TEST(norm(soft.V_WB[0].v - plain.V_WB[0].v) < 1e-8);
          BOOST_TEST(norm(soft.X_WB[0].p - plain.X_WB[0].p) < 1e-10);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_step_that_has_no_solution_in_numbers_leaves_all_at_rest) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Nodes nodes(1);
    nodes.inertia *= 0.01;
    nodes.free[1] = bad;
    nodes.contacts = {touch(-0.001, 1500, 2, 0.3)};
    BodyStates bodies;
    bodies.count = 1;
    bodies.X_WB[0].p = {1, 2, 3};
    bodies.V_WB[0].v = {0.1, 0, 0};
    RigidStep rigid(tool_of(0.05), 1);
    BOOST_TEST((nodes.step(rigid, {}, {}, bodies).outcome == StepOutcome::stopped));
    BOOST_TEST((bodies.X_WB[0].p == Vec3{1, 2, 3}));
    BOOST_TEST((bodies.V_WB[0].v == Vec3{}));
    BOOST_TEST(nodes.force.isZero(0));
    BOOST_TEST(nodes.after.isZero(0));
  }
}

BOOST_AUTO_TEST_SUITE_END()
