#include "devices/simulated/handle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "devices/simulated/matrix_exponential.hpp"

namespace tactor {

namespace {

/// However fast the cogging is, a tick of a millisecond takes no more than a thousand steps.
constexpr double shortest_step = 1e-6;

Friction friction_of(const HandleParameters& coupling) {
  return Friction(
      {.coulomb = coupling.coulomb, .breakaway = coupling.breakaway, .stribeck_velocity = coupling.stribeck_velocity});
}

/// Motors and handle with a transmission between; where there is none, handle and hand with a grip between.
MassChain<2>::Parameters two_bodies(const HandleParameters& c, const TransmissionParameters& link) {
  MassChain<2>::Parameters two{
      .damping = c.damping, .hand_stiffness = c.hand_stiffness, .hand_damping = c.hand_damping};
  if (link.motor_mass > 0) {
    two.mass = {link.motor_mass, c.inertia - link.motor_mass};
    two.link = {{{link.stiffness, link.damping}}};
    two.half_gap = link.half_gap;
  } else {
    two.mass = {c.inertia - c.hand_inertia, c.hand_inertia};
    two.link = {{{c.grip_stiffness, c.grip_damping}}};
  }
  return two;
}

/// Motors, handle and hand, with transmission and grip between.
MassChain<3>::Parameters three_bodies(const HandleParameters& c, const TransmissionParameters& link) {
  return {.mass = {link.motor_mass, c.inertia - c.hand_inertia - link.motor_mass, c.hand_inertia},
          .link = {{{link.stiffness, link.damping}, {c.grip_stiffness, c.grip_damping}}},
          .half_gap = link.half_gap,
          .damping = c.damping,
          .hand_stiffness = c.hand_stiffness,
          .hand_damping = c.hand_damping};
}

/// The mass (kg) that cogging acts on.
double cogged_mass(const HandleParameters& c, const TransmissionParameters& link) {
  if (link.motor_mass > 0) return link.motor_mass;
  return c.has_grip() ? c.inertia - c.hand_inertia : c.inertia;
}

/// The rotation vector of R (rad) that is nearest to `before`, of those that differ by whole turns.
Vec3 unwound(const Quat& R, const Vec3& before) {
  constexpr double turn = 2 * std::numbers::pi, no_angle = 1e-9;
  const Vec3 v = to_rotation_vector(R);
  const double angle = norm(v), wound = norm(before);
  if (angle <= no_angle && wound <= no_angle) return v;
  const Vec3 axis = angle > no_angle ? v / angle : before / wound;
  const double turns = std::nearbyint((dot(before, axis) - angle) / turn);
  return turns != 0 ? v + (turns * turn) * axis : v;
}

/// The longest step that resolves the device's own fast motions, at most `sub_step`.
double step_for(double sub_step, double cogged_mass, const Cogging& cogging, double longest_step) {
  double step = std::min(sub_step, longest_step);
  // A twentieth of the swing about a rest position of the cogging; impulses are stable up to a third of it.
  if (cogging.acts()) step = std::min(step, 0.3 * std::sqrt(cogged_mass / cogging.stiffness()));
  return std::max(step, std::min(sub_step, shortest_step));
}

}  // namespace

Handle::Handle(const HandleParameters& translation, const HandleParameters& rotation, double sub_step, bool rotate,
               const DeviceParts& parts)
    : translation_(translation),
      rotation_(rotation),
      rotate_(rotate),
      amplifier_(parts.amplifier),
      friction_(friction_of(translation)),
      friction_angle_(friction_of(rotation)),
      cogging_(parts.cogging),
      has_transmission_(parts.transmission.motor_mass > 0),
      two_(two_bodies(translation, parts.transmission), friction_, cogging_),
      three_(three_bodies(translation, parts.transmission), friction_, cogging_),
      turning_(two_bodies(rotation, {}), friction_angle_, Cogging({})) {
  sub_step_ = step_for(sub_step, cogged_mass(translation, parts.transmission), cogging_,
                       translation.has_grip() ? three_.longest_step() : two_.longest_step());
}

void Handle::place(const MotionState& state) {
  state_ = state;
  motor_ = state;
  hand_ = state;
  grip_W_ = arc_W_ = {};
}

Handle::Propagator Handle::make_propagator(const HandleParameters& coupling, double h) {
  // d/dt (x, v, f) = (v, (f - K x - B v) / M, 0).
  const double damping = coupling.damping + coupling.hand_damping;
  const SquareMatrix<3> step = exponential<3>(
      {{{0, h, 0},
        {-h * coupling.hand_stiffness / coupling.inertia, -h * damping / coupling.inertia, h / coupling.inertia},
        {0, 0, 0}}});
  return {.x_v = step[0][1], .x_f = step[0][2], .v_v = step[1][1], .v_f = step[1][2]};
}

Vec3 Handle::move(const HandleParameters& coupling, const Friction& friction, const Cogging* cogging,
                  const Propagator& by, double h, const Vec3& f, const Vec3& x, Vec3& v) {
  const Vec3 ripple = cogging != nullptr ? cogging->force(x) : Vec3{};
  const bool holds = norm(f + ripple) <= friction.holds();
  if (v == Vec3{} && holds) return {};
  v = friction.slowed(v, 0.5 * h, coupling.inertia);
  if (v == Vec3{} && holds && (friction.has_breakaway() || cogging != nullptr)) return {};
  if (cogging != nullptr) v += (0.5 * h / coupling.inertia) * ripple;
  const Vec3 way = by.x_v * v + by.x_f * f;
  v = by.v_v * v + by.v_f * f;
  if (cogging != nullptr) v += (0.5 * h / coupling.inertia) * cogging->force(x + way);
  v = friction.slowed(v, 0.5 * h, coupling.inertia);
  return way;
}

void Handle::translate_bodies(double h, const Vec3& motor_F_W, const Vec3& hand_F_W) {
  const auto point = [](const MotionState& state) { return PointState{state.X.p, state.V.v}; };
  const auto put = [](MotionState& state, const PointState& to) {
    state.X.p = to.p;
    state.V.v = to.v;
  };
  if (has_transmission_ && translation_.has_grip()) {
    MassChain<3>::Points points{point(motor_), point(state_), point(hand_)};
    three_.advance(h, motor_F_W, hand_F_W, points);
    put(motor_, points[0]);
    put(state_, points[1]);
    put(hand_, points[2]);
    return;
  }
  MotionState& last = has_transmission_ ? state_ : hand_;
  MassChain<2>::Points points{point(motor_), point(last)};
  two_.advance(h, motor_F_W, hand_F_W, points);
  put(motor_, points[0]);
  put(last, points[1]);
  put(has_transmission_ ? hand_ : state_, points[has_transmission_ ? 1 : 0]);
}

void Handle::translate(double h, const Propagator& by, const Vec3& motor_F_W, const MotionState& target) {
  const Vec3 spring_F_W = translation_.hand_stiffness * (target.X.p - hand_.X.p);
  const Vec3 damper_F_W = translation_.hand_damping * target.V.v;
  const Vec3 before = motor_.X.p;
  if (has_transmission_ || translation_.has_grip()) {
    translate_bodies(h, motor_F_W, spring_F_W + damper_F_W);
  } else {
    const Cogging* cogging = cogging_.acts() ? &cogging_ : nullptr;
    state_.X.p +=
        move(translation_, friction_, cogging, by, h, motor_F_W + spring_F_W + damper_F_W, state_.X.p, state_.V.v);
    motor_.X.p = hand_.X.p = state_.X.p;
    motor_.V.v = hand_.V.v = state_.V.v;
  }
  work_ += dot(motor_F_W, motor_.X.p - before);
}

void Handle::turn(double h, const Propagator& by, const Vec3& motor_T_W, const MotionState& target) {
  arc_W_ = unwound(target.X.R * inverse(hand_.X.R), arc_W_);
  const Vec3 spring_T_W = rotation_.hand_stiffness * arc_W_, damper_T_W = rotation_.hand_damping * target.V.w;
  if (rotation_.has_grip()) return turn_in_grip(h, motor_T_W, spring_T_W + damper_T_W);
  const Vec3 torque_W = motor_T_W + spring_T_W + damper_T_W;
  const Vec3 turn_W = move(rotation_, friction_angle_, nullptr, by, h, torque_W, {}, state_.V.w);
  state_.X.R = normalized(from_rotation_vector(turn_W) * state_.X.R);
  hand_.X.R = state_.X.R;
  hand_.V.w = state_.V.w;
  work_ += dot(motor_T_W, turn_W);
}

void Handle::turn_in_grip(double h, const Vec3& motor_T_W, const Vec3& hand_T_W) {
  // From where the handle is: it at zero, the hand at the arc by which the grip is twisted.
  grip_W_ = unwound(hand_.X.R * inverse(state_.X.R), grip_W_);
  MassChain<2>::Points points{PointState{{}, state_.V.w}, PointState{grip_W_, hand_.V.w}};
  turning_.advance(h, motor_T_W, hand_T_W, points);
  state_.X.R = normalized(from_rotation_vector(points[0].p) * state_.X.R);
  hand_.X.R = normalized(from_rotation_vector(points[1].p - grip_W_) * hand_.X.R);
  state_.V.w = points[0].v;
  hand_.V.w = points[1].v;
  work_ += dot(motor_T_W, points[0].p);
}

void Handle::advance(double dt, const Wrench& commanded, const MotionState& from, const MotionState& to) {
  if (dt <= 0) return;
  const int steps = std::max(1, static_cast<int>(std::ceil(dt / sub_step_ - 1e-9)));
  const double h = dt / steps;
  const Propagators& by = propagators_.get(h, [this](double step, Propagators& made) {
    made.translate = make_propagator(translation_, step);
    if (rotate_) made.rotate = make_propagator(rotation_, step);
  });
  for (int i = 0; i < steps; ++i) {
    const MotionState target = interpolate(from, to, dt, (i + 0.5) / steps, rotate_);
    const Wrench motors = amplifier_.advance(h, commanded);
    translate(h, by.translate, motors.force, target);
    if (rotate_) {
      turn(h, by.rotate, motors.torque, target);
    } else {
      state_.X.R = hand_.X.R = target.X.R;
    }
    motor_.X.R = state_.X.R;
    motor_.V.w = state_.V.w;
  }
}

void Handle::advance_amplifier(double dt, const Wrench& commanded) {
  if (dt > 0) amplifier_.advance(dt, commanded);
}

}  // namespace tactor
