#include "bench/stability/judge.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/coupling/law.hpp"
#include "nodes/mechanics/coupling_wrench.hpp"
#include "nodes/scene/body_mesh.hpp"

namespace tactor::bench {

namespace {

Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::not_finite:
      return "not_finite";
    case Verdict::energy:
      return "energy";
    case Verdict::pushed_through:
      return "pushed_through";
    case Verdict::limit_cycle:
      return "limit_cycle";
    case Verdict::stable:
      return "stable";
  }
  return "";
}

void Swing::see(double x) {
  if (!begun_) low_ = high_ = x;
  begun_ = true;
  low_ = std::min(low_, x);
  high_ = std::max(high_, x);
  rise_ = std::max(rise_, x - low_);
  fall_ = std::max(fall_, high_ - x);
}

Judge::Judge(const Trial& trial) : trial_(trial), rotates_(trial.scene.rotates()), rests_(trial.rests.size()) {
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
  sum += 0.5 * trial_.law.k_t * dot(stretch, stretch);
  if (!rotates_) return sum;
  const Vec3 turn = to_rotation_vector(state.device.X_WD.R * inverse(X_WT.R));
  return sum + 0.5 * trial_.law.k_r * dot(turn, turn);
}

void Judge::begin(const ContactSet& set) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const Contact& c = set.contact[i];
    const double depth = std::max(0.0, -c.distance);
    came_in_ += 0.5 * c.stiffness * c.weight * depth * depth;
  }
}

bool Judge::see(const Reached& state) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Pose& X = state.bodies.X_WB[i];
    const Twist& V = state.bodies.V_WB[i];
    const double turn = X.R.w + X.R.x + X.R.y + X.R.z;
    finite_ = finite_ && is_finite(X.p) && std::isfinite(turn) && is_finite(V.v) && is_finite(V.w);
  }
  const double now = energy(state);
  if (!begun_ && finite_) {
    begun_ = true;
    start_ = now + came_in_;
  } else if (finite_) {
    CouplingLaw law = trial_.law;
    law.force_max = law.torque_max = std::numeric_limits<double>::infinity();
    const PhysicsState physics{.X_WT = state.bodies.X_WB[0],
                               .V_WT = state.bodies.V_WB[0],
                               .X_WD = state.device.X_WD,
                               .V_WD = state.device.V_WD};
    const Wrench on_device = coupling_wrench(law, physics, rotates_);
    const Vec3 way = state.device.X_WD.p - last_.device.X_WD.p;
    double given = -dot(on_device.force, way);
    if (rotates_) {
      given -= dot(on_device.torque, to_rotation_vector(state.device.X_WD.R * inverse(last_.device.X_WD.R)));
    }
    given_ += given;
    came_in_ += std::max(0.0, given);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Vec3 fallen = state.bodies.X_WB[i].p - last_.bodies.X_WB[i].p;
      came_in_ += std::max(0.0, bodies_[i].mass * dot(trial_.scene.gravity_W, fallen));
    }
    surplus_ = std::max(surplus_, now - start_ - given_);
    finite_ = std::isfinite(now) && std::isfinite(given_);
  }
  last_ = state;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    const double t = state.t.seconds();
    if (t < trial_.rests[k].begin || t > trial_.rests[k].end + 1e-9) continue;
    const Pose& X = state.bodies.X_WB[0];
    for (int i = 0; i < 3; ++i) rests_[k].swing[i].see(X.p[i]);
    if (rotates_) {
      const Vec3 arm = trial_.lever * to_rotation_vector(X.R * inverse(state.device.X_WD.R));
      for (int i = 0; i < 3; ++i) rests_[k].swing[3 + i].see(arm[i]);
    }
    rests_[k].last = X.p;
    rests_[k].seen = true;
  }
  return finite_;
}

void Judge::finish(Finding& finding) const {
  finding.verdict = Verdict::stable;
  finding.generated = came_in_ > 0 ? surplus_ / came_in_ : 0;
  if (!finite_) {
    finding.verdict = Verdict::not_finite;
    return;
  }
  finding.swing = 0;
  bool through = false;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    const AtRest& found = rests_[k];
    if (!found.seen) continue;
    for (const Swing& s : found.swing) finding.swing = std::max(finding.swing, s.size());
    const Rest& rest = trial_.rests[k];
    if (!rest.p_WT) continue;
    const Vec3 off = found.last - *rest.p_WT;
    const double error = norm({off.x * rest.known.x, off.y * rest.known.y, off.z * rest.known.z});
    finding.rest_error = std::isnan(finding.rest_error) ? error : std::max(finding.rest_error, error);
    through = through || error > rest.tolerance;
  }
  if (surplus_ > surplus_min && surplus_ > generated_max * came_in_) {
    finding.verdict = Verdict::energy;
  } else if (through) {
    finding.verdict = Verdict::pushed_through;
  } else if (finding.swing > trial_.swing_max) {
    finding.verdict = Verdict::limit_cycle;
  }
}

}  // namespace tactor::bench
