#include "nodes/effect/device_dynamics.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

namespace tactor {

namespace {

using std::numbers::pi;

/// Motor side, handle, hand, the motors' force and the held command. Of bodies that move as one, the first.
enum : Eigen::Index { x_1, v_1, x_2, v_2, x_h, v_h, motor_f, command, states };

/// A body by its position's place in the state, its velocity being the next, and its mass (kg).
struct Moving {
  Eigen::Index x;
  double mass;
};

/// A spring (N/m) and a damper (N s/m) from a body to what stands still.
void hold(Eigen::MatrixXd& a, const Moving& body, double k, double c) {
  a(body.x + 1, body.x) -= k / body.mass;
  a(body.x + 1, body.x + 1) -= c / body.mass;
}

/// The same between two.
void join(Eigen::MatrixXd& a, const Moving& first, const Moving& second, double k, double c) {
  for (const auto& [one, other] : {std::pair{first, second}, {second, first}}) {
    hold(a, one, k, c);
    a(one.x + 1, other.x) += k / one.mass;
    a(one.x + 1, other.x + 1) += c / one.mass;
  }
}

Eigen::MatrixXd rates(const DeviceDynamics& d) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(states, states);
  // Without a pole the command is the force.
  const double corner = 2 * pi * d.amplifier_bandwidth;
  const Eigen::Index force = corner > 0 ? motor_f : command;
  if (corner > 0) a(motor_f, motor_f) = -corner, a(motor_f, command) = corner;
  a(x_1, v_1) = a(x_2, v_2) = a(x_h, v_h) = 1;

  const bool has_mode = d.mode_frequency > 0, has_grip = d.grip_stiffness > 0 || d.grip_damping > 0;
  const double motors = has_mode ? d.motor_share * d.mass : 0, rest = d.mass - motors;
  const Moving handle{x_2, rest + (has_grip ? 0 : d.hand_mass)};
  const Moving driven = has_mode ? Moving{x_1, motors} : handle;
  const Moving held = has_grip ? Moving{x_h, d.hand_mass} : handle;
  a(driven.x + 1, force) = 1 / driven.mass;
  hold(a, driven, 0, d.damping);
  hold(a, held, d.hand_stiffness, d.hand_damping);
  if (has_grip) join(a, handle, held, d.grip_stiffness, d.grip_damping);
  if (has_mode) {
    const double turn = 2 * pi * d.mode_frequency, reduced = motors * rest / d.mass;
    join(a, driven, handle, turn * turn * reduced, 2 * d.mode_damping * turn * reduced);
  }
  return a;
}

}  // namespace

std::vector<double> tick_response(const DeviceDynamics& device, double tick, std::size_t ticks) {
  const Eigen::MatrixXd step = (tick * rates(device)).exp();
  Eigen::VectorXd state = Eigen::VectorXd::Zero(states);
  state(command) = 1;
  std::vector<double> response(ticks);
  for (double& mean : response) {
    const double before = state(v_2);
    state = step * state;
    mean = (state(v_2) - before) / tick;
    state(command) = 0;
  }
  return response;
}

AccelerationMatch match_acceleration(const DeviceDynamics& device, double tick, const std::vector<double>& wanted,
                                     double effort, std::size_t fade) {
  const std::size_t ticks = wanted.size() + fade;
  const auto n = static_cast<Eigen::Index>(ticks), asked = static_cast<Eigen::Index>(wanted.size());
  const std::vector<double> h = tick_response(device, tick, ticks);
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index row = 0; row < n; ++row) {
    for (Eigen::Index column = 0; column <= row; ++column) {
      response(row, column) = h[static_cast<std::size_t>(row - column)];
    }
  }
  Eigen::VectorXd a = Eigen::VectorXd::Zero(n);
  a.head(asked) = Eigen::Map<const Eigen::VectorXd>(wanted.data(), asked);
  const double weight = effort / (device.mass + device.hand_mass);
  Eigen::MatrixXd normal = response.transpose() * response;
  normal.diagonal().array() += weight * weight;
  Eigen::VectorXd u = normal.ldlt().solve(response.transpose() * a);
  for (std::size_t k = 0; k < fade; ++k) {
    u(asked + static_cast<Eigen::Index>(k)) *= static_cast<double>(fade - k) / static_cast<double>(fade + 1);
  }
  AccelerationMatch match;
  match.force.assign(u.data(), u.data() + n);
  const double size = a.norm();
  match.error = size > 0 ? (a - response * u).head(asked).norm() / size : 0;
  return match;
}

std::vector<double> decaying_sinusoid(double amplitude, double frequency, double decay, double tick,
                                      std::size_t ticks) {
  // The velocity gained until t is the imaginary part of amplitude (exp(s t) - 1) / s.
  const std::complex<double> s(-1 / decay, 2 * pi * frequency);
  std::vector<double> mean(ticks);
  for (std::size_t n = 0; n < ticks; ++n) {
    const double begin = static_cast<double>(n) * tick;
    mean[n] = amplitude * (std::exp(s * begin) * (std::exp(s * tick) - 1.0) / s).imag() / tick;
  }
  return mean;
}

}  // namespace tactor
