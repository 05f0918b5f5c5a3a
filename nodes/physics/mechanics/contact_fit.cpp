#include "nodes/physics/mechanics/contact_fit.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Vector6 = ContactFit::Vector6;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double force_noise = 0.02;  // N
constexpr double model_noise = 0.05;  // of the forces
constexpr double depth_noise = 2e-6;  // m
constexpr double least_scale = 0.1, most_scale = 10, most_excess = 2;
constexpr double drift_scale = 0.004;  // of the scale, with a result
constexpr double drift_excess = 0.004;
constexpr double telling = 0.5;      // of the scale, or of a coefficient: known better than that
constexpr double sure_to_slide = 2;  // times the stick velocity
constexpr double surprise = 9;       // three standard deviations, squared
constexpr int iterations = 20;

bool of_tool(const ContactPair& pair) {
  return pair.body == 0 || pair.other == 0;
}

/// N, what inertia and lift add to the normal force `alone` of a contact of the tool. `rate`, m/s^2: of the relative
/// velocity along the normal; `speed`, m/s: of sliding.
double beyond_spring(const Contact& c, double alone, double rate, double speed) {
  const double with_inertia = alone - c.inertia * c.weight * rate;
  const double lift = c.lift * c.friction * c.damping * c.weight;
  const double give = c.weight > 0 ? c.creep * c.friction / c.weight : 0;
  const double with_lift = std::max(0.0, (with_inertia + lift * speed) / (1 + lift * give));
  return with_inertia - alone + lift * std::max(0.0, speed - give * with_lift);
}

/// The variance of what is not known at all; of a scale well above 1 it is the share that is not known.
Matrix2d unknown(double scale) {
  return Vector2d(std::max(1.0, scale * scale), 1).asDiagonal();
}

}  // namespace

/// The wrench and its slopes at some (a, e).
struct ContactFit::Model {
  Vector6 wrench = Vector6::Zero();
  Eigen::Matrix<double, 6, 2> slopes = Eigen::Matrix<double, 6, 2>::Zero();
};

/// What physics has beyond the model at some (a, e), and what the slopes there make of it.
struct ContactFit::Difference {
  Matrix6 weight;  // inverse variance, less by what the slopes cannot make
  Matrix2d told;   // the information that the result has of (a, e)
  Vector2d pull;
  double base = 0;  // N^2, the variance without contacts that stick
  [[nodiscard]] bool finite() const { return weight.allFinite() && told.allFinite() && pull.allFinite(); }
  /// The square of what is off, in standard deviations, if (a, e) is known with the variance P.
  [[nodiscard]] double off(const Matrix2d& P) const {
    Matrix2d spread = told * P * told + told;
    spread.diagonal().array() += 1e-9 * spread.trace() + 1e-12;
    return pull.dot(spread.inverse() * pull);
  }
};

bool ContactFit::Materials::has(const Material& material) const {
  const auto end = of.begin() + count;
  return std::find(of.begin(), end, material) != end;
}

void ContactFit::Materials::add(const Material& material) {
  if (count < most_materials && !has(material)) of[static_cast<std::size_t>(count++)] = material;
}

bool ContactFit::Materials::any_of(const Materials& others) const {
  return std::any_of(of.begin(), of.begin() + count, [&others](const Material& mine) { return others.has(mine); });
}

/// Sets what pushes the tool where the bodies are, with its levers and the noise of its depths; returns how many do.
int ContactFit::collect(const BodyStates& bodies, bool massless, const Twist& acceleration, Materials& materials) {
  push_count_ = 0;
  lowest_ = 0;
  double depth_variance = 0, levers = 0, sum = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const ContactPair& pair = pairs_[i];
    Contact& c = contacts_[i];
    scales_.apply_scales(c);
    const ContactPlanes plane{
        std::span(bodies.X_WB).first(static_cast<std::size_t>(bodies.count)), {&c, 1}, {&pair, 1}};
    if (!usable(plane, 0, bodies.count)) continue;
    const bool apart = !(c.distance < 0);
    const double k = c.stiffness * c.weight, b = massless || (apart && c.inertia > 0) ? 0 : c.damping * c.weight;
    const Vec3 p_W = transform(bodies.X_WB[static_cast<std::size_t>(pair.body)], c.p_TC);
    const Vec3 u = relative_velocity(bodies, pair, p_W);
    const double approach = dot(c.n_W, u), sign = pair.body == 0 ? 1 : -1;
    const Vec3 u_t = u - approach * c.n_W;
    const double speed = norm(u_t);
    double N = -k * c.distance - b * approach;
    if (!massless && !apart && (c.inertia > 0 || c.lift > 0)) {
      const Vec3 rate = acceleration.v + cross(acceleration.w, p_W - bodies.X_WB[0].p);
      N += beyond_spring(c, N, sign * dot(c.n_W, rate), speed);
    }
    if (!(N > 0)) continue;
    Push& push = pushes_[static_cast<std::size_t>(push_count_++)];
    push.N = N;
    push.friction = c.friction;
    push.slides = speed > sure_to_slide * stick_velocity_;
    if (c.creep > 0) push.slides = push.slides && c.weight * speed > sure_to_slide * c.creep * c.friction * N;
    push.n = sign * c.n_W;
    push.lever = rotates_ ? p_W - bodies.X_WB[0].p : Vec3{};
    push.rub << eigen(speed > 0 ? (-sign * N / speed) * u_t : Vec3{}), 0, 0, 0;
    materials.add({c.stiffness, c.damping, c.friction});
    lowest_ = std::min(lowest_, -c.friction);
    depth_variance += k * k * depth_noise * depth_noise;
    levers += N * dot(push.lever, push.lever);
    sum += N;
  }
  depth_noise_ = std::sqrt(depth_variance);
  lever_ = levers > 0 ? std::sqrt(levers / sum) : 1;
  for (Push& push : std::span(pushes_).first(static_cast<std::size_t>(push_count_))) {
    push.normal << push.N * eigen(push.n), (push.N / lever_) * eigen(cross(push.lever, push.n));
    const Vec3 rub = plain(push.rub.head<3>());
    push.rub.tail<3>() = (1 / lever_) * eigen(cross(push.lever, rub));
  }
  return push_count_;
}

/// The variance of the wrench around the model, N^2; `base` is that of each of its numbers without the contacts that
/// stick.
Matrix6 ContactFit::noise(const Vector6& measured, const Vector2d& at, double& base) const {
  double sum = 0;
  Matrix6 unknown = Matrix6::Zero();
  for (const Push& push : std::span(pushes_).first(static_cast<std::size_t>(push_count_))) {
    const double friction = std::max(0.0, push.friction + at[1]);
    sum += push.N * (1 + friction);
    if (push.slides) continue;
    // Any two directions across the normal.
    const Vec3 x = std::abs(push.n.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 t1 = cross(push.n, x) / norm(cross(push.n, x)), t2 = cross(push.n, t1);
    for (const Vec3& t : {t1, t2}) {
      Vector6 force;
      force << eigen(t), (1 / lever_) * eigen(cross(push.lever, t));
      // Far more than the cone of the model, which is what is asked for.
      const double most = 10 * (1 + friction) * at[0] * push.N;
      unknown += most * most * force * force.transpose();
    }
  }
  const double size = std::max(measured.head<3>().norm(), at[0] * sum);
  const double depth = at[0] * depth_noise_;
  base = force_noise * force_noise + model_noise * model_noise * size * size + depth * depth;
  unknown.diagonal().array() += base;
  return unknown;
}

ContactFit::Model ContactFit::model(const Vector2d& at, bool all_slide) const {
  Model m;
  for (const Push& push : std::span(pushes_).first(static_cast<std::size_t>(push_count_))) {
    m.slopes.col(0) += push.normal;
    if (!push.slides && !all_slide) continue;
    const double friction = push.friction + at[1];
    if (friction > 0) m.slopes.col(0) += friction * push.rub;
    // One whose friction has come down to zero may go up again.
    if (friction >= 0) m.slopes.col(1) += at[0] * push.rub;
  }
  m.wrench = at[0] * m.slopes.col(0);
  return m;
}

ContactFit::Difference ContactFit::difference(const Vector6& measured, const Vector2d& at) const {
  Difference d;
  d.weight = noise(measured, at, d.base).inverse();
  const Model m = model(at, false);
  const Vector6 left = measured - m.wrench;
  d.told = m.slopes.transpose() * d.weight * m.slopes;
  d.pull = m.slopes.transpose() * d.weight * left;
  Matrix2d bounded = d.told;
  bounded.diagonal().array() += 1e-9 * d.told.trace() + 1e-12;
  const double without_slope = left.dot(d.weight * left) - d.pull.dot(bounded.inverse() * d.pull);
  const double more = std::max(1.0, without_slope / (rotates_ ? 4 : 1));
  d.weight /= more;
  d.told /= more;
  d.pull /= more;
  d.base *= more;
  return d;
}

/// Moves the estimate to what is known with a measurement whose inverse variance is `weight`: steps of Gauss and Newton
/// within the bounds, where a number that would leave them stands there and the other makes the best of it. False where
/// they do not come to rest.
bool ContactFit::fuse(const Vector6& measured, const Matrix6& weight, bool all_slide, Estimate& estimate) const {
  const Matrix2d prior = estimate.P.inverse();
  const Vector2d lowest(least_scale, lowest_), highest(most_scale, most_excess);
  Vector2d at = estimate.x;
  for (int i = 0; i < iterations; ++i) {
    const Model m = model(at, all_slide);
    const Eigen::Matrix<double, 2, 6> weighted = m.slopes.transpose() * weight;
    const Matrix2d known = prior + weighted * m.slopes;
    const Vector2d slope = weighted * (measured - m.wrench) + prior * (estimate.x - at);
    const Matrix2d variance = known.inverse();
    Vector2d step = variance * slope;
    for (const int j : {0, 1}) {
      const double bound = std::clamp(at[j] + step[j], lowest[j], highest[j]);
      if (bound == at[j] + step[j]) continue;
      const int other = 1 - j;
      step[j] = bound - at[j];
      step[other] = (slope[other] - known(other, j) * step[j]) / known(other, other);
    }
    const Vector2d next = (at + step).cwiseMax(lowest).cwiseMin(highest);
    if (!next.allFinite() || !variance.allFinite()) return false;
    const bool at_rest = (next - at).cwiseAbs().maxCoeff() < 1e-6;
    at = next;
    if (!at_rest) continue;
    estimate = {at, 0.5 * (variance + variance.transpose())};
    return estimate.P(0, 0) > 0 && estimate.P(1, 1) > 0 && estimate.P.determinant() > 0;
  }
  return false;
}

/// Where the contacts that stick hold more than their friction could, it must be more. False where there is none that
/// could hold it.
bool ContactFit::raise_by_sticking(const Vector6& measured, double base, Estimate& estimate) const {
  Vector6 along = Vector6::Zero();
  double pressed = 0;
  for (const Push& push : std::span(pushes_).first(static_cast<std::size_t>(push_count_))) {
    if (push.slides) continue;
    along += push.rub;
    pressed += push.N;
  }
  const double length = along.norm();
  if (!(length > 0.1 * pressed)) return true;
  along /= length;
  // What they hold beyond their friction.
  const auto beyond = [&](const Vector2d& x) {
    double held = 0;
    for (const Push& push : std::span(pushes_).first(static_cast<std::size_t>(push_count_))) {
      if (!push.slides) held += push.N * std::max(0.0, push.friction + x[1]);
    }
    return along.dot(measured - model(x, false).wrench) - x[0] * length * held / pressed;
  };
  if (!(beyond(estimate.x) > std::sqrt(base))) return true;
  if (!fuse(measured, along * along.transpose() / base, true, estimate)) return false;
  return estimate.x[1] < most_excess || beyond(estimate.x) < std::sqrt(surprise * base);
}

/// Moves the estimate by a result. False where what comes out does not explain it.
bool ContactFit::learn(const Vector6& measured, const Difference& now, Estimate& estimate) const {
  if (!fuse(measured, now.weight, false, estimate)) return false;
  if (!raise_by_sticking(measured, now.base, estimate)) return false;
  const Difference then = difference(measured, estimate.x);
  return then.finite() && then.pull.dot((then.told + 1e-12 * Matrix2d::Identity()).inverse() * then.pull) <= surprise;
}

/// Whether the surprise before would have it so too.
bool ContactFit::confirms(const Estimate& alone, const Materials& materials) const {
  if (!candidate_for_.any_of(materials)) return false;
  const Vector2d apart = alone.x - candidate_.x;
  return apart.dot((alone.P + candidate_.P).inverse() * apart) <= surprise;
}

/// An excess so low that it leaves what pushes now without any friction stays as it is, unless there is friction.
void ContactFit::keep_excess_below_use(const Estimate& before, Estimate& estimate) const {
  if (before.x[1] >= lowest_ || estimate.x[1] > lowest_ + 3 * std::sqrt(estimate.P(1, 1))) return;
  estimate.x[1] = before.x[1];
  estimate.P(1, 1) = before.P(1, 1);
  estimate.P(0, 1) = estimate.P(1, 0) = 0;
}

FitOutcome ContactFit::update(const Vector6& measured, const Materials& materials) {
  const Estimate known{{error_.stiffness_scale, error_.friction_excess}, P_};
  Estimate estimate = known;
  estimate.x[1] = std::max(known.x[1], lowest_);
  const Difference now = difference(measured, estimate.x);
  if (!now.finite()) return FitOutcome::unusable;

  // Measured against what it is or what this result alone would have it, whichever is more, as far as it may go: a
  // graze of the model where physics pushes hard is no stiffness.
  const double larger = std::min(most_scale, std::max(known.x[0], known.x[0] + now.pull[0] / now.told(0, 0)));
  const bool of_scale = now.told(0, 0) * telling * telling * larger * larger > 1;
  const bool of_friction = now.told(1, 1) * telling * telling > 1;
  if (!of_scale && !of_friction) return FitOutcome::silent;
  const Matrix2d most = unknown(larger);
  const auto drift = [&estimate, &most](int i, double by) {
    double& variance = estimate.P(i, i);
    variance = std::max(variance, std::min(most(i, i), variance + by * by));
  };
  if (of_scale) drift(0, drift_scale * known.x[0]);
  if (of_friction) drift(1, drift_excess);

  const bool off = now.off(estimate.P) > surprise;
  // Where so much is new, what was known does not hold it back.
  if (off) estimate.P = 10 * most;
  bool explained = learn(measured, now, estimate);
  const bool confirmed = off && explained && confirms(estimate, materials);
  const Estimate alone = estimate;
  if (confirmed) {
    estimate = candidate_;
    explained = learn(measured, now, estimate);
  }
  candidate_for_ = {};
  if (!explained) {
    ++unexplained_;
    return FitOutcome::unexplained;
  }
  if (off && !confirmed) {
    candidate_ = alone;
    candidate_for_ = materials;
    return FitOutcome::awaiting;
  }
  keep_excess_below_use(known, estimate);
  error_ = {estimate.x[0], estimate.x[1]};
  P_ = estimate.P;
  surprises_ += off ? 1 : 0;
  used_for_friction_ += of_friction ? 1 : 0;
  return FitOutcome::used;
}

FitOutcome ContactFit::take(Time valid, const LocalContacts& contacts, const BodyStates& bodies, bool massless,
                            const Wrench& contact_T_W, int touching, const Twist& acceleration) {
  if (any_ && valid <= last_) return FitOutcome::repeated;
  if (!is_scene(contacts, bodies, bodies.count)) return FitOutcome::unusable;
  count_ = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    if (!of_tool(contacts.pair[i])) continue;
    pairs_[count_] = contacts.pair[i];
    contacts_[count_++] = contact_now(contacts, i, bodies);
  }
  return take_gathered(valid, bodies, massless, contact_T_W, touching, acceleration);
}

FitOutcome ContactFit::take(Time valid, const ContactPlanes& planes, const BodyStates& bodies, bool massless,
                            const Wrench& contact_T_W, int touching, const Twist& acceleration) {
  if (any_ && valid <= last_) return FitOutcome::repeated;
  if (!is_scene({}, bodies, bodies.count) || planes.planes.size() > contacts_.size()) return FitOutcome::unusable;
  count_ = 0;
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    if (!of_tool(planes.pairs[i]) || !usable(planes, i, bodies.count)) continue;
    const PlaneNow now = plane_now(planes, i, bodies.X_WB);
    Contact& c = contacts_[count_];
    c = planes.planes[i];
    c.n_W = now.n_W;
    c.distance = now.distance;
    pairs_[count_++] = planes.pairs[i];
  }
  return take_gathered(valid, bodies, massless, contact_T_W, touching, acceleration);
}

FitOutcome ContactFit::take_gathered(Time valid, const BodyStates& bodies, bool massless, const Wrench& contact_T_W,
                                     int touching, const Twist& acceleration) {
  Vector6 measured;
  measured << eigen(contact_T_W.force), eigen(rotates_ ? contact_T_W.torque : Vec3{});
  if (!std::isfinite(measured.squaredNorm())) return FitOutcome::unusable;
  Materials materials;
  const bool pushes = collect(bodies, massless, acceleration, materials) > 0;
  measured.tail<3>() /= lever_;
  if (touching <= 0 || !pushes) {
    const Vector2d at(error_.stiffness_scale, error_.friction_excess);
    law_error_ = (touching > 0 ? measured : model(at, false).wrench).head<3>().norm();
    return FitOutcome::silent;
  }
  const FitOutcome outcome = learn_from(valid, measured, materials);
  law_error_ = left_over(measured);
  return outcome;
}

/// Of physics' wrench beyond the model's, in N, without the directions in which contacts stick.
double ContactFit::left_over(const Vector6& measured) const {
  const Vector2d at(error_.stiffness_scale, error_.friction_excess);
  double base = 0;
  const Matrix6 weight = noise(measured, at, base).inverse();
  const Vector6 left = measured - model(at, false).wrench;
  const double square = base * left.dot(weight * left);
  return std::isfinite(square) ? std::sqrt(std::max(0.0, square)) : 0;
}

FitOutcome ContactFit::learn_from(Time valid, const Vector6& measured, const Materials& materials) {
  const ContactError known = error_;
  const Matrix2d known_variance = P_;
  const bool foreign = materials_.count > 0 && !materials.any_of(materials_);
  if (foreign) {
    error_ = {};
    P_ = Estimate{}.P;
  }
  const FitOutcome outcome = update(measured, materials);
  if (outcome == FitOutcome::used || outcome == FitOutcome::awaiting) {
    any_ = true;
    last_ = valid;
  }
  if (outcome != FitOutcome::used) {
    error_ = known;
    P_ = known_variance;
    return outcome;
  }
  materials_ = materials;
  ++used_;
  resets_ += foreign ? 1 : 0;
  return FitOutcome::used;
}

ContactCorrection ContactFit::correction() const {
  return {.scale_all = scales_.scale_all,
          .friction_scale_all = scales_.friction_scale_all,
          .stiffness_scale = error_.stiffness_scale,
          .friction_excess = error_.friction_excess,
          .count = materials_.count,
          .material = materials_.of};
}

}  // namespace tactor
