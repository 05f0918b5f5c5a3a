// A single body on the coupling, stepped against planes that do not move.
#pragma once

#include <vector>

#include "nodes/physics/mechanics/energy.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor::test {

class OneBody {
 public:
  explicit OneBody(const SystemModel& model) : step_(model) { bodies.count = 1; }

  StepResult advance(double h, const DeviceState& device = {}) {
    const DeviceState from = before_;
    before_ = device;
    return step_.advance(coupling, from, device, planes(), h, bodies);
  }
  [[nodiscard]] ContactPlanes planes() {
    pairs_.assign(contacts.size(), {});
    return {std::span(&query, 1), contacts, pairs_};
  }
  [[nodiscard]] double energy() { return system_energy(step_.model(), coupling, before_, planes(), bodies).total(); }
  Pose& X() { return bodies.X_WB[0]; }
  Twist& V() { return bodies.V_WB[0]; }

  CouplingParameters coupling;
  std::vector<Contact> contacts;
  Pose query;  ///< of the body, for the contacts
  BodyStates bodies;

 private:
  RigidStep step_;
  DeviceState before_;
  std::vector<ContactPair> pairs_;
};

/// A block of principal inertias mass * (1, 2, 3) cm^2 under gravity along -z.
inline SystemModel block(double mass, bool rotates = false) {
  SystemModel m;
  m.body[0].mass = mass;
  m.body[0].inertia_B = mass * Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  m.body[0].rotates = rotates;
  m.gravity_W = {0, 0, -9.81};
  return m;
}

/// k in N/m, and 1e-3 k in N m/rad, damped by zeta for `block(mass)`.
inline CouplingParameters spring(double k, double mass, double zeta = 1) {
  return {.k_t = k,
          .b_t = 2 * zeta * std::sqrt(k * mass),
          .k_r = k * 1e-3,
          .b_r = 2 * zeta * std::sqrt(k * 1e-3 * mass * 2e-4)};
}

/// A plane with normal +z that the body's point p_BC is `height` above while the body is at the query's pose.
inline Contact floor_at(const Vec3& p_BC, double height, double k = 2000, double b = 2, double mu = 0.3) {
  return {.p_TC = p_BC,
          .p_WC = {p_BC.x, p_BC.y, p_BC.z - height},
          .n_W = {0, 0, 1},
          .distance = height,
          .weight = 1,
          .stiffness = k,
          .damping = b,
          .friction = mu};
}

}  // namespace tactor::test
