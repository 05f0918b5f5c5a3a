#include "nodes/effect/device_dynamics.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

namespace tactor {

namespace {

using std::numbers::pi;

/// x_1, v_1, x_2, v_2, f and the held command u; one body is both.
enum : Eigen::Index { x_1, v_1, x_2, v_2, motor_f, command, states };

Eigen::MatrixXd rates(const DeviceDynamics& d) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(states, states);
  // Without a pole the command is the force.
  const double corner = 2 * pi * d.amplifier_bandwidth;
  const Eigen::Index force = corner > 0 ? motor_f : command;
  if (corner > 0) a(motor_f, motor_f) = -corner, a(motor_f, command) = corner;
  a(x_1, v_1) = a(x_2, v_2) = 1;
  if (d.mode_frequency <= 0) {
    const double m = d.mass + d.hand_mass;
    a(v_2, force) = 1 / m;
    a(v_2, v_2) = -(d.damping + d.hand_damping) / m;
    a(v_2, x_2) = -d.hand_stiffness / m;
    return a;
  }
  const double m_1 = d.motor_share * d.mass, rest = d.mass - m_1, m_2 = rest + d.hand_mass;
  const double turn = 2 * pi * d.mode_frequency, reduced = m_1 * rest / d.mass;
  const double k = turn * turn * reduced, c = 2 * d.mode_damping * turn * reduced;
  a(v_1, force) = 1 / m_1;
  a(v_1, v_1) = -(d.damping + c) / m_1;
  a(v_1, x_1) = -k / m_1;
  a(v_1, v_2) = c / m_1;
  a(v_1, x_2) = k / m_1;
  a(v_2, v_2) = -(d.hand_damping + c) / m_2;
  a(v_2, x_2) = -(d.hand_stiffness + k) / m_2;
  a(v_2, v_1) = c / m_2;
  a(v_2, x_1) = k / m_2;
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
                                     double effort) {
  const auto n = static_cast<Eigen::Index>(wanted.size());
  const std::vector<double> h = tick_response(device, tick, wanted.size());
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index row = 0; row < n; ++row) {
    for (Eigen::Index column = 0; column <= row; ++column) {
      response(row, column) = h[static_cast<std::size_t>(row - column)];
    }
  }
  const Eigen::Map<const Eigen::VectorXd> a(wanted.data(), n);
  const double weight = effort / (device.mass + device.hand_mass);
  Eigen::MatrixXd normal = response.transpose() * response;
  normal.diagonal().array() += weight * weight;
  const Eigen::VectorXd u = normal.ldlt().solve(response.transpose() * a);
  AccelerationMatch match;
  match.force.assign(u.data(), u.data() + n);
  const double size = a.norm();
  match.error = size > 0 ? (a - response * u).norm() / size : 0;
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
