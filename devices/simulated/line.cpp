#include "devices/simulated/line.hpp"

namespace tactor {

namespace {

bool is_force(const Wrench& wrench) {
  return wrench.force != Vec3{} || wrench.torque != Vec3{};
}

AxisValues as_axes(const Wrench& wrench) {
  return {wrench.force.x, wrench.force.y, wrench.force.z, wrench.torque.x, wrench.torque.y, wrench.torque.z};
}

}  // namespace

SimulatedLine::SimulatedLine(std::size_t ticks_in, std::size_t ticks_out, const LineEnergyOptions& energy,
                             const Vec3& weight_W, bool rotates)
    : weight_W_(weight_W), rotates_(rotates), energy_(energy), in_(ticks_in), out_(ticks_out) {}

MotionState SimulatedLine::receive(const ShownMotion& shown, bool counts) {
  const ShownMotion came = in_.pass(shown);
  if (counts) count(came);
  return came.motion;
}

void SimulatedLine::count(const ShownMotion& came) {
  if (rotates_ && any_) turned_W_ += to_rotation_vector(came.motion.X.R * inverse(counted_.motion.X.R));
  any_ = true;
  counted_ = came;
  const Vec3& p = came.motion.X.p;
  energy_.take(came.read, {p.x, p.y, p.z, turned_W_.x, turned_W_.y, turned_W_.z});
}

void SimulatedLine::send(Time now, const Wrench& commanded_D_W, double gain, bool counts) {
  Wrench given = commanded_D_W;
  if (counts) {
    const AxisValues effort = energy_.give(now, as_axes(commanded_D_W), as_axes({gain * weight_W_, {}}));
    given = {{effort[0], effort[1], effort[2]}, {effort[3], effort[4], effort[5]}};
  }
  held_D_W_ = out_.pass(given);
}

void SimulatedLine::let_go(Time at) {
  held_D_W_ = {};
  out_.fill({});
  energy_.let_go(at);
}

bool SimulatedLine::acts() const {
  return is_force(held_D_W_) || out_.any_of(is_force);
}

}  // namespace tactor
