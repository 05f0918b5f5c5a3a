#include "bench/stability/judge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/coupling/coupling_node.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor::bench {

namespace {

Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

Judge::Judge(const Trial& trial)
    : trial_(trial),
      rotates_(trial.scene.rotates()),
      judge_({.peak_to_peak_max = trial.peak_to_peak_max}, trial.rests) {
  for (const std::size_t i : trial.scene.moving()) {
    const Body& body = trial.scene.bodies[i];
    const bool turns = body.motion == Motion::rigid;
    bodies_.push_back({body.mass, turns ? body_inertia(body) : Eigen::Matrix3d::Zero().eval()});
  }
}

double Judge::energy(const Reached& state) const {
  double sum = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const double m = bodies_[i].mass;
    const Twist& V = state.bodies.V_WB[i];
    const Pose& X = state.bodies.X_WB[i];
    sum += m * (0.5 * dot(V.v, V.v) - dot(trial_.scene.gravity_W, X.p));
    if (bodies_[i].I_B.isZero(0)) continue;
    const Eigen::Vector3d w_B = eigen(rotate(inverse(X.R), V.w));
    sum += 0.5 * w_B.dot(bodies_[i].I_B * w_B);
  }
  const Pose& X_WT = state.bodies.X_WB[0];
  const Vec3 stretch = state.device.X_WD.p - X_WT.p;
  sum += 0.5 * trial_.coupling.k_t * dot(stretch, stretch);
  if (!rotates_) return sum;
  const Vec3 turn = to_rotation_vector(state.device.X_WD.R * inverse(X_WT.R));
  return sum + 0.5 * trial_.coupling.k_r * dot(turn, turn);
}

void Judge::begin(const ContactSet& set) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const Contact& c = set.contact[i];
    const double depth = std::max(0.0, -c.distance);
    judge_.add_stored(0.5 * c.stiffness * c.weight * depth * depth);
  }
}

bool Judge::is_finite_state(const Reached& state) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Pose& X = state.bodies.X_WB[i];
    const Twist& V = state.bodies.V_WB[i];
    const double turn = X.R.w + X.R.x + X.R.y + X.R.z;
    if (!is_finite(X.p) || !std::isfinite(turn) || !is_finite(V.v) || !is_finite(V.w)) return false;
  }
  return true;
}

double Judge::given(const Reached& state) const {
  CouplingParameters coupling = trial_.coupling;
  coupling.force_max = coupling.torque_max = std::numeric_limits<double>::infinity();
  const PhysicsState physics{
      .X_WT = state.bodies.X_WB[0], .V_WT = state.bodies.V_WB[0], .X_WD = state.device.X_WD, .V_WD = state.device.V_WD};
  const Wrench on_device = coupling_wrench(coupling, physics, rotates_);
  double given = -dot(on_device.force, state.device.X_WD.p - last_.device.X_WD.p);
  if (rotates_) {
    given -= dot(on_device.torque, to_rotation_vector(state.device.X_WD.R * inverse(last_.device.X_WD.R)));
  }
  return given;
}

bool Judge::see(const Reached& state) {
  StabilitySample sample{.t = state.t.seconds(), .p_WT = state.bodies.X_WB[0].p, .finite = is_finite_state(state)};
  if (sample.finite) {
    sample.stored = energy(state);
    if (rotates_) {
      sample.arm = trial_.lever * to_rotation_vector(state.bodies.X_WB[0].R * inverse(state.device.X_WD.R));
    }
    if (begun_) {
      sample.given = given(state);
      for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const Vec3 fallen = state.bodies.X_WB[i].p - last_.bodies.X_WB[i].p;
        sample.released += std::max(0.0, bodies_[i].mass * dot(trial_.scene.gravity_W, fallen));
      }
    }
    begun_ = true;
    last_ = state;
  }
  return judge_.see(sample);
}

void Judge::finish(Finding& finding) const {
  const StabilityFinding found = judge_.finish();
  finding.verdict = found.verdict;
  finding.generated = found.generated_share;
  if (found.verdict == StabilityVerdict::not_finite) return;
  finding.peak_to_peak = found.peak_to_peak_m;
  if (found.off_m) finding.rest_error = *found.off_m;
}

}  // namespace tactor::bench
