#include "devices/simulated/transmission.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "devices/simulated/matrix_exponential.hpp"

namespace tactor {

TransmissionParameters transmission_of(double mass, double motor_share, double frequency, double damping_ratio,
                                       double backlash) {
  if (frequency <= 0) return {};
  const double motor_mass = motor_share * mass;
  const double reduced_mass = motor_mass * (mass - motor_mass) / mass;
  const double omega = 2 * std::numbers::pi * frequency;
  return {.motor_mass = motor_mass,
          .stiffness = omega * omega * reduced_mass,
          .damping = 2 * damping_ratio * omega * reduced_mass,
          .half_gap = 0.5 * backlash};
}

Transmission::Transmission(const Parameters& parameters, const Friction& motor_friction, const Cogging& cogging)
    : parameters_(parameters), friction_(motor_friction), cogging_(cogging) {}

double Transmission::longest_step() const {
  if (parameters_.link.half_gap <= 0) return std::numeric_limits<double>::infinity();
  // A tenth of the half swing that a contact lasts.
  const double m_1 = parameters_.link.motor_mass, m_2 = parameters_.handle_mass;
  return 0.1 * std::numbers::pi * std::sqrt(m_1 * m_2 / (m_1 + m_2) / parameters_.link.stiffness);
}

void Transmission::make_levels(bool held, bool touching, Levels& levels) const noexcept {
  const Parameters& p = parameters_;
  const double k = touching ? p.link.stiffness : 0, c = touching ? p.link.damping : 0;
  const bool divided = p.link.half_gap > 0;
  const double h = divided ? std::ldexp(h_, -finest) : h_;
  // Time in units of h: the state is (y_1, h v_1, y_2, h v_2, h^2 f_1 / m_1, h^2 f_2 / m_2), all of them in m.
  SquareMatrix<6> a{};
  a[0][1] = 1;
  a[2][3] = 1;
  if (!held) {
    const double m = p.link.motor_mass;
    a[1] = {-h * h * k / m, -h * (p.damping + c) / m, h * h * k / m, h * c / m, 1, 0};
  } else {
    a[0][1] = 0;
  }
  const double m = p.handle_mass;
  a[3] = {h * h * k / m, h * c / m, -h * h * (k + p.hand_stiffness) / m, -h * (c + p.hand_damping) / m, 0, 1};
  SquareMatrix<6> e = exponential(a);
  for (int level = divided ? finest : 0; level >= 0; --level) {
    Propagator& by = levels[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < 4; ++i) {
      const double unit = i % 2 == 0 ? 1 : 1 / h;  // of the row, out
      by[i] = {unit * e[i][1] * h, unit * e[i][3] * h, unit * e[i][4] * h * h / p.link.motor_mass,
               unit * e[i][5] * h * h / p.handle_mass};
    }
    if (level > 0) e = product(e, e);
  }
}

void Transmission::prepare(double h) noexcept {
  if (h == h_) return;
  h_ = h;
  const bool may_hold = friction_.holds() > 0;
  const bool may_part = parameters_.link.half_gap > 0;
  for (const bool held : {false, true}) {
    if (held && !may_hold) continue;
    for (const bool touching : {false, true}) {
      if (touching || may_part) make_levels(held, touching, levels_[held ? 1 : 0][touching ? 1 : 0]);
    }
  }
}

double Transmission::side_of(double d) const noexcept {
  const double g = parameters_.link.half_gap;
  return g <= 0 ? 1 : d > g ? 1 : d < -g ? -1 : 0;
}

Vec3 Transmission::link_force(const PointState& motor, const PointState& handle) const noexcept {
  Vec3 force;
  for (int i = 0; i < 3; ++i) {
    const double d = handle.p[i] - motor.p[i];
    const double side = side_of(d);
    if (side != 0) {
      force[i] = parameters_.link.stiffness * (d - side * parameters_.link.half_gap) +
                 parameters_.link.damping * (handle.v[i] - motor.v[i]);
    }
  }
  return force;
}

void Transmission::step(Axis& axis, const Propagator& by, double side, double motor_f, double hand_f,
                        double start) const noexcept {
  // The propagator starts from y = 0: what the springs are bent by here is a constant force.
  const double d = axis.x_2 - axis.x_1 - side * parameters_.link.half_gap;
  const double spring = side != 0 ? parameters_.link.stiffness * d : 0;
  const double f_1 = motor_f + spring;
  const double f_2 = hand_f - parameters_.hand_stiffness * (axis.x_2 - start) - spring;
  const auto row = [&](std::size_t i) {
    return by[i][0] * axis.v_1 + by[i][1] * axis.v_2 + by[i][2] * f_1 + by[i][3] * f_2;
  };
  const double y_1 = row(0), v_1 = row(1), y_2 = row(2), v_2 = row(3);
  axis = {axis.x_1 + y_1, v_1, axis.x_2 + y_2, v_2};
}

void Transmission::advance_axis(Axis& axis, bool held, double motor_f, double hand_f) const noexcept {
  const auto& regimes = levels_[held ? 1 : 0];
  const double start = axis.x_2;
  if (parameters_.link.half_gap <= 0) {
    step(axis, regimes[1][0], 1, motor_f, hand_f, start);
    return;
  }
  constexpr int end = 1 << finest;
  int at = 0, size = end;  // in units of h / 2^finest
  int level = 0;
  double side = side_of(axis.x_2 - axis.x_1);
  while (at < end) {
    Axis next = axis;
    step(next, regimes[side != 0 ? 1 : 0][static_cast<std::size_t>(level)], side, motor_f, hand_f, start);
    const double next_side = side_of(next.x_2 - next.x_1);
    if (next_side != side && size > 1) {
      size /= 2;
      ++level;
      continue;
    }
    axis = next;
    side = next_side;
    at += size;
    // As long as the place allows: a step begins at a multiple of its length.
    while (level > 0 && at % (2 * size) == 0) {
      size *= 2;
      --level;
    }
  }
}

void Transmission::advance(double h, const Vec3& motor_F_W, const Vec3& hand_F_W, PointState& motor,
                           PointState& handle) noexcept {
  prepare(h);
  const double m_1 = parameters_.link.motor_mass;
  const Vec3 ripple = cogging_.force(motor.p);
  const bool holds = friction_.holds() > 0 && norm(motor_F_W + ripple + link_force(motor, handle)) <= friction_.holds();
  motor.v = friction_.slowed(motor.v, 0.5 * h, m_1);
  const bool held = holds && motor.v == Vec3{};
  if (!held) motor.v += (0.5 * h / m_1) * ripple;
  for (int i = 0; i < 3; ++i) {
    Axis axis{motor.p[i], motor.v[i], handle.p[i], handle.v[i]};
    advance_axis(axis, held, motor_F_W[i], hand_F_W[i]);
    motor.p[i] = axis.x_1;
    motor.v[i] = axis.v_1;
    handle.p[i] = axis.x_2;
    handle.v[i] = axis.v_2;
  }
  if (!held) motor.v = friction_.slowed(motor.v + (0.5 * h / m_1) * cogging_.force(motor.p), 0.5 * h, m_1);
}

}  // namespace tactor
