#include "devices/simulated/mass_chain.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "devices/simulated/matrix_exponential.hpp"

namespace tactor {

template <std::size_t N>
MassChain<N>::MassChain(const Parameters& parameters, const Friction& motor_friction, const Cogging& cogging)
    : parameters_(parameters), friction_(motor_friction), cogging_(cogging) {}

template <std::size_t N>
double MassChain<N>::longest_step() const {
  if (parameters_.half_gap <= 0) return std::numeric_limits<double>::infinity();
  // A tenth of the half swing that a contact lasts. What hangs on the second mass makes it last longer.
  const double m_1 = parameters_.mass[0], m_2 = parameters_.mass[1];
  return 0.1 * std::numbers::pi * std::sqrt(m_1 * m_2 / (m_1 + m_2) / parameters_.link[0].stiffness);
}

template <std::size_t N>
void MassChain<N>::make_levels(double whole_h, bool held, bool touching, Levels& levels) const noexcept {
  const Parameters& p = parameters_;
  const bool divided = p.half_gap > 0;
  const double h = divided ? std::ldexp(whole_h, -finest) : whole_h;
  // Time in units of h: the state is (y_1, h v_1, y_2, h v_2, ..., h^2 f_1 / m_1, h^2 f_2 / m_2, ...), all of it in m.
  SquareMatrix<3 * N> a{};
  Link left{0, p.damping};
  for (std::size_t i = 0; i < N; ++i) {
    Link right = i + 1 < N ? p.link[i] : Link{p.hand_stiffness, p.hand_damping};
    if (i == 0 && !touching) right = {};
    const double m = p.mass[i];
    auto& speed = a[2 * i + 1];
    if (i > 0 || !held) {
      a[2 * i][2 * i + 1] = 1;
      speed[2 * i] = -h * h * (left.stiffness + right.stiffness) / m;
      speed[2 * i + 1] = -h * (left.damping + right.damping) / m;
      if (i > 0) {
        speed[2 * i - 2] = h * h * left.stiffness / m;
        speed[2 * i - 1] = h * left.damping / m;
      }
      if (i + 1 < N) {
        speed[2 * i + 2] = h * h * right.stiffness / m;
        speed[2 * i + 3] = h * right.damping / m;
      }
      speed[2 * N + i] = 1;
    }
    left = right;
  }
  SquareMatrix<3 * N> e = exponential(a);
  for (int level = divided ? finest : 0; level >= 0; --level) {
    Propagator& by = levels[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < 2 * N; ++i) {
      const double unit = i % 2 == 0 ? 1 : 1 / h;  // of the row, out
      for (std::size_t j = 0; j < N; ++j) {
        by[i][j] = unit * e[i][2 * j + 1] * h;
        by[i][N + j] = unit * e[i][2 * N + j] * h * h / p.mass[j];
      }
    }
    if (level > 0) e = product(e, e);
  }
}

template <std::size_t N>
void MassChain<N>::make_regimes(double h, Regimes& regimes) const noexcept {
  const bool may_hold = friction_.holds() > 0;
  const bool may_part = parameters_.half_gap > 0;
  for (const bool held : {false, true}) {
    if (held && !may_hold) continue;
    for (const bool touching : {false, true}) {
      if (touching || may_part) make_levels(h, held, touching, regimes[held ? 1 : 0][touching ? 1 : 0]);
    }
  }
}

template <std::size_t N>
double MassChain<N>::side_of(double d) const noexcept {
  const double g = parameters_.half_gap;
  return g <= 0 ? 1 : d > g ? 1 : d < -g ? -1 : 0;
}

template <std::size_t N>
Vec3 MassChain<N>::link_force(const PointState& motor, const PointState& next) const noexcept {
  Vec3 force;
  for (int i = 0; i < 3; ++i) {
    const double d = next.p[i] - motor.p[i];
    const double side = side_of(d);
    if (side != 0) {
      force[i] = parameters_.link[0].stiffness * (d - side * parameters_.half_gap) +
                 parameters_.link[0].damping * (next.v[i] - motor.v[i]);
    }
  }
  return force;
}

template <std::size_t N>
void MassChain<N>::step(Axis& axis, const Propagator& by, double side, double motor_f, double hand_f,
                        double start) const noexcept {
  // The propagator starts from y = 0: what the springs are bent by here is a constant force.
  std::array<double, N> f{};
  f[0] = motor_f;
  f[N - 1] = hand_f - parameters_.hand_stiffness * (axis.x[N - 1] - start);
  for (std::size_t i = 0; i + 1 < N; ++i) {
    const double gap = i == 0 ? side * parameters_.half_gap : 0;
    const bool touches = i > 0 || side != 0;
    const double spring = touches ? parameters_.link[i].stiffness * (axis.x[i + 1] - axis.x[i] - gap) : 0;
    f[i] += spring;
    f[i + 1] -= spring;
  }
  const auto row = [&](std::size_t i) {
    double sum = by[i][0] * axis.v[0];
    for (std::size_t j = 1; j < N; ++j) sum += by[i][j] * axis.v[j];
    for (std::size_t j = 0; j < N; ++j) sum += by[i][N + j] * f[j];
    return sum;
  };
  Axis next{};
  for (std::size_t i = 0; i < N; ++i) {
    next.x[i] = axis.x[i] + row(2 * i);
    next.v[i] = row(2 * i + 1);
  }
  axis = next;
}

template <std::size_t N>
void MassChain<N>::advance_axis(Axis& axis, const std::array<Levels, 2>& by, double motor_f,
                                double hand_f) const noexcept {
  const double start = axis.x[N - 1];
  if (parameters_.half_gap <= 0) {
    step(axis, by[1][0], 1, motor_f, hand_f, start);
    return;
  }
  constexpr int end = 1 << finest;
  int at = 0, size = end;  // in units of h / 2^finest
  int level = 0;
  double side = side_of(axis.x[1] - axis.x[0]);
  while (at < end) {
    Axis next = axis;
    step(next, by[side != 0 ? 1 : 0][static_cast<std::size_t>(level)], side, motor_f, hand_f, start);
    const double next_side = side_of(next.x[1] - next.x[0]);
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

template <std::size_t N>
void MassChain<N>::advance(double h, const Vec3& motor_F_W, const Vec3& hand_F_W, Points& points) noexcept {
  const Regimes& regimes = regimes_.get(h, [this](double step, Regimes& made) { make_regimes(step, made); });
  PointState& motor = points[0];
  const double m_1 = parameters_.mass[0];
  const Vec3 ripple = cogging_.force(motor.p);
  const bool holds =
      friction_.holds() > 0 && norm(motor_F_W + ripple + link_force(motor, points[1])) <= friction_.holds();
  motor.v = friction_.slowed(motor.v, 0.5 * h, m_1);
  const bool held = holds && motor.v == Vec3{};
  if (!held) motor.v += (0.5 * h / m_1) * ripple;
  for (int i = 0; i < 3; ++i) {
    Axis axis{};
    for (std::size_t j = 0; j < N; ++j) {
      axis.x[j] = points[j].p[i];
      axis.v[j] = points[j].v[i];
    }
    advance_axis(axis, regimes[held ? 1 : 0], motor_F_W[i], hand_F_W[i]);
    for (std::size_t j = 0; j < N; ++j) {
      points[j].p[i] = axis.x[j];
      points[j].v[i] = axis.v[j];
    }
  }
  if (!held) motor.v = friction_.slowed(motor.v + (0.5 * h / m_1) * cogging_.force(motor.p), 0.5 * h, m_1);
}

template class MassChain<2>;
template class MassChain<3>;

}  // namespace tactor
