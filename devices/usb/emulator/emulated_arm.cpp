#include "devices/usb/emulator/emulated_arm.hpp"

#include <algorithm>
#include <cmath>

#include "devices/falcon/delta_arm.hpp"
#include "devices/usb/wooden_arm.hpp"

namespace tactor {

namespace {

constexpr double longest_step = 1e-4;  // s
constexpr double least_inertia = 1e-5;

class Linear final : public ArmGeometry {
 public:
  explicit Linear(const std::vector<double>& numbers) {
    for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
      const Vec3 direction{numbers[i], numbers[i + 1], numbers[i + 2]};
      directions_.push_back((1.0 / norm(direction)) * direction);
    }
  }
  [[nodiscard]] int axes() const override { return static_cast<int>(directions_.size()); }
  [[nodiscard]] bool at(const std::array<double, 6>& q, Vec3& p_BD, std::array<Vec3, 6>& J) const override {
    p_BD = {};
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      J[i] = directions_[i];
      p_BD += q[i] * directions_[i];
    }
    return is_finite(p_BD);
  }
  [[nodiscard]] bool reach(const Vec3& p_BD, std::array<double, 6>& q) const override {
    for (std::size_t i = 0; i < directions_.size(); ++i) q[i] = dot(directions_[i], p_BD);
    return true;
  }

 private:
  std::vector<Vec3> directions_;
};

class Wooden final : public ArmGeometry {
 public:
  explicit Wooden(const std::vector<double>& n) : arm_({n[0], n[1], n[2], {n[3], n[4], n[5]}}) {}
  [[nodiscard]] int axes() const override { return 3; }
  [[nodiscard]] bool at(const std::array<double, 6>& q, Vec3& p_BD, std::array<Vec3, 6>& J) const override {
    const std::array<double, 3> angles{q[0], q[1], q[2]};
    p_BD = arm_.forward(angles);
    const auto columns = arm_.jacobian(angles);
    std::copy(columns.begin(), columns.end(), J.begin());
    return is_finite(p_BD);
  }
  [[nodiscard]] bool reach(const Vec3& p_BD, std::array<double, 6>& q) const override {
    const auto angles = arm_.inverse(p_BD);
    if (angles) std::copy(angles->begin(), angles->end(), q.begin());
    return angles.has_value();
  }

 private:
  WoodenArm arm_;
};

class Delta final : public ArmGeometry {
 public:
  [[nodiscard]] int axes() const override { return 3; }
  [[nodiscard]] bool at(const std::array<double, 6>& q, Vec3& p_BD, std::array<Vec3, 6>& J) const override {
    const std::array<double, 3> theta{q[0], q[1], q[2]};
    const auto p = arm_.forward(theta);
    if (!p) return false;
    const auto columns = arm_.jacobian(theta, *p);
    if (!columns) return false;
    p_BD = *p;
    std::copy(columns->begin(), columns->end(), J.begin());
    return true;
  }
  [[nodiscard]] bool reach(const Vec3& p_BD, std::array<double, 6>& q) const override {
    const auto theta = arm_.inverse(p_BD);
    if (theta) std::copy(theta->begin(), theta->end(), q.begin());
    return theta.has_value();
  }

 private:
  DeltaArm arm_;
};

}  // namespace

std::unique_ptr<ArmGeometry> make_arm_geometry(const std::string& kind, const std::vector<double>& numbers) {
  if (kind == "linear" && !numbers.empty() && numbers.size() % 3 == 0 && numbers.size() <= 9) {
    return std::make_unique<Linear>(numbers);
  }
  if (kind == "wooden" && numbers.size() == 6) return std::make_unique<Wooden>(numbers);
  if (kind == "delta" && numbers.empty()) return std::make_unique<Delta>();
  return nullptr;
}

EmulatedArm::EmulatedArm(std::unique_ptr<ArmGeometry> geometry, HandModel hand)
    : geometry_(std::move(geometry)), hand_(std::move(hand)) {}

bool EmulatedArm::place(const Vec3& p_BD) {
  std::array<double, 6> q{};
  if (!geometry_->reach(p_BD, q) || !geometry_->at(q, p_, J_)) return false;
  q_ = q;
  rate_ = {};
  start_ = p_;
  time_ = 0;
  given_ = 0;
  return true;
}

Vec3 EmulatedArm::on_path(double time) const {
  if (hand_.points.empty()) return start_;
  const double length = hand_.times.back();
  const double t = length > 0 ? std::fmod(time, length) : 0;
  const auto after =
      static_cast<std::size_t>(std::upper_bound(hand_.times.begin(), hand_.times.end(), t) - hand_.times.begin());
  if (after == 0) return hand_.points.front();
  if (after == hand_.times.size()) return hand_.points.back();
  const double share = (t - hand_.times[after - 1]) / (hand_.times[after] - hand_.times[after - 1]);
  return (1 - share) * hand_.points[after - 1] + share * hand_.points[after];
}

Vec3 EmulatedArm::target(double time) const {
  if (time < hand_.hold || hand_.points.empty()) return start_;
  const double gone = time - hand_.hold;
  if (gone >= hand_.approach) return on_path(gone - hand_.approach);
  const double x = gone / hand_.approach;
  const double share = x * x * (3 - 2 * x);
  return (1 - share) * start_ + share * hand_.points.front();
}

void EmulatedArm::step(double dt, const std::array<double, 6>& torque) {
  Vec3 v;
  for (int i = 0; i < axes(); ++i) v += rate_[static_cast<std::size_t>(i)] * J_[static_cast<std::size_t>(i)];
  const Vec3 wanted = target(time_), soon = target(time_ + dt);
  const Vec3 F =
      hand_.stiffness * (wanted - p_) + hand_.damping * ((1 / dt) * (soon - wanted) - v) - hand_.friction * v;
  std::array<double, 6> q = q_;
  for (int i = 0; i < axes(); ++i) {
    const auto a = static_cast<std::size_t>(i);
    const double inertia = std::max(hand_.mass * dot(J_[a], J_[a]), least_inertia);
    rate_[a] += dt * (torque[a] + dot(J_[a], F)) / inertia;
    q[a] += dt * rate_[a];
  }
  time_ += dt;
  Vec3 p;
  std::array<Vec3, 6> J{};
  if (geometry_->at(q, p, J)) {
    for (std::size_t i = 0; i < q.size(); ++i) given_ += torque[i] * (q[i] - q_[i]);
    q_ = q;
    p_ = p;
    J_ = J;
  } else {
    rate_ = {};  // at the end of its travel
  }
}

void EmulatedArm::advance(double dt, const std::array<double, 6>& torque) {
  if (!(dt > 0)) return;
  const int steps = static_cast<int>(std::ceil(dt / longest_step));
  for (int i = 0; i < steps; ++i) step(dt / steps, torque);
}

}  // namespace tactor
