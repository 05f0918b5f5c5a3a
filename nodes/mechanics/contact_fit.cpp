#include "nodes/mechanics/contact_fit.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "nodes/mechanics/eigen.hpp"
#include "nodes/mechanics/local_rollout.hpp"

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
constexpr int iterations = 8;

Vec3 velocity_at(const BodyStates& bodies, std::int32_t i, const Vec3& p_W) {
  if (i == ContactPair::fixed) return {};
  const auto body = static_cast<std::size_t>(i);
  return bodies.V_WB[body].v + cross(bodies.V_WB[body].w, p_W - bodies.X_WB[body].p);
}

bool of_tool(const ContactPair& pair) {
  return pair.body == 0 || pair.other == 0;
}

double clamp_excess(double e, double lowest) {
  return std::clamp(e, std::min(lowest, 0.0), most_excess);
}

}  // namespace

/// The wrench and its slopes at some (a, e).
struct ContactFit::Model {
  Vector6 wrench = Vector6::Zero();
  Eigen::Matrix<double, 6, 2> slopes = Eigen::Matrix<double, 6, 2>::Zero();
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
int ContactFit::collect(const LocalContacts& contacts, const BodyStates& bodies, bool massless, Materials& materials) {
  push_count_ = 0;
  lowest_ = 0;
  double depth_variance = 0, levers = 0, sum = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    const ContactPair& pair = contacts.pair[i];
    if (!of_tool(pair)) continue;
    const Contact c = contact_now(contacts, i, bodies);
    const ContactPlanes plane{
        std::span(bodies.X_WB).first(static_cast<std::size_t>(bodies.count)), {&c, 1}, {&pair, 1}};
    if (!usable(plane, 0, bodies.count)) continue;
    const double k = c.stiffness * c.weight, b = massless ? 0 : c.damping * c.weight;
    const Vec3 p_W = transform(bodies.X_WB[static_cast<std::size_t>(pair.body)], c.p_TC);
    const Vec3 u = velocity_at(bodies, pair.body, p_W) - velocity_at(bodies, pair.other, p_W);
    const double approach = dot(c.n_W, u);
    const double N = -k * c.distance - b * approach;
    if (!(N > 0)) continue;
    Push& push = pushes_[static_cast<std::size_t>(push_count_++)];
    const Vec3 u_t = u - approach * c.n_W;
    const double speed = norm(u_t), sign = pair.body == 0 ? 1 : -1;
    push.N = N;
    push.friction = c.friction;
    push.slides = speed > sure_to_slide * stick_velocity_;
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
Matrix6 ContactFit::noise(const Vector6& measured, double& base) const {
  double sum = 0;
  Matrix6 unknown = Matrix6::Zero();
  for (const Push& push : std::span(pushes_).first(static_cast<std::size_t>(push_count_))) {
    const double friction = std::max(0.0, push.friction + error_.friction_excess);
    sum += push.N * (1 + friction);
    if (push.slides) continue;
    // Any two directions across the normal.
    const Vec3 x = std::abs(push.n.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 t1 = cross(push.n, x) / norm(cross(push.n, x)), t2 = cross(push.n, t1);
    for (const Vec3& t : {t1, t2}) {
      Vector6 force;
      force << eigen(t), (1 / lever_) * eigen(cross(push.lever, t));
      // Far more than the cone of the model, which is what is asked for.
      const double most = 10 * (1 + friction) * error_.stiffness_scale * push.N;
      unknown += most * most * force * force.transpose();
    }
  }
  const double size = std::max(measured.head<3>().norm(), error_.stiffness_scale * sum);
  const double depth = error_.stiffness_scale * depth_noise_;
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

/// Moves x and P, what is known before, to what is known with a measurement whose inverse variance is `weight`. False,
/// and nothing changes, where the numbers do not serve.
bool ContactFit::fuse(const Vector6& measured, const Matrix6& weight, bool all_slide, Vector2d& x, Matrix2d& P) const {
  const Matrix2d prior = P.inverse();
  Vector2d at = x;
  Matrix2d variance = P;
  for (int i = 0; i < iterations; ++i) {
    const Model m = model(at, all_slide);
    const Eigen::Matrix<double, 2, 6> weighted = m.slopes.transpose() * weight;
    variance = (prior + weighted * m.slopes).inverse();
    const Vector2d next = x + variance * (weighted * (measured - m.wrench - m.slopes * (x - at)));
    if (!next.allFinite() || !variance.allFinite()) return false;
    const Vector2d before = at;
    at = {std::clamp(next[0], least_scale, most_scale), clamp_excess(next[1], lowest_)};
    if ((at - before).cwiseAbs().maxCoeff() < 1e-6) break;
  }
  // A number that stands at its bound is what the other has to make the best of.
  x = at;
  P = 0.5 * (variance + variance.transpose());
  return P(0, 0) > 0 && P(1, 1) > 0 && P.determinant() > 0;
}

/// Where the contacts that stick hold more than their friction could, it must be more.
bool ContactFit::raise_by_sticking(const Vector6& measured, double base, Vector2d& x, Matrix2d& P) const {
  Vector6 along = Vector6::Zero();
  double held = 0, pressed = 0;
  for (const Push& push : std::span(pushes_).first(static_cast<std::size_t>(push_count_))) {
    if (push.slides) continue;
    along += push.rub;
    held += push.N * std::max(0.0, push.friction + x[1]);
    pressed += push.N;
  }
  const double length = along.norm();
  if (!(length > 0.1 * pressed)) return true;
  along /= length;
  const double rest = along.dot(measured - model(x, false).wrench);
  const double most = x[0] * length * held / pressed;
  if (!(rest > most + std::sqrt(base))) return true;
  return fuse(measured, along * along.transpose() / base, true, x, P);
}

FitOutcome ContactFit::update(const Vector6& measured) {
  double base = 0;
  const Matrix6 variance = noise(measured, base);
  Matrix6 weight = variance.inverse();
  Vector2d x(error_.stiffness_scale, error_.friction_excess);
  const Model m = model(x, false);
  if (!weight.allFinite() || !m.wrench.allFinite()) return FitOutcome::unusable;

  // What the two numbers could explain of the difference, and what they could not.
  const Vector6 difference = measured - m.wrench;
  Matrix2d told = m.slopes.transpose() * weight * m.slopes;
  Vector2d pull = m.slopes.transpose() * weight * difference;
  Matrix2d bounded = told;
  bounded.diagonal().array() += 1e-9 * told.trace() + 1e-12;
  const double unexplained = difference.dot(weight * difference) - pull.dot(bounded.inverse() * pull);
  const double excess = std::max(1.0, unexplained / (rotates_ ? 4 : 1));
  weight /= excess;
  told /= excess;
  pull /= excess;

  Matrix2d P = P_;
  // Measured against what it is or what this result alone would have it, whichever is more, as far as it may go: a
  // graze of the model where physics pushes hard is no stiffness.
  const double larger = std::min(most_scale, std::max(x[0], x[0] + pull[0] / told(0, 0)));
  const bool of_scale = told(0, 0) * telling * telling * larger * larger > 1;
  const bool of_friction = told(1, 1) * telling * telling > 1;
  if (!of_scale && !of_friction) return FitOutcome::silent;
  // Of a scale well above 1 it is the share that is not known.
  Matrix2d most = start_variance();
  most(0, 0) *= std::max(1.0, larger * larger);
  const auto drift = [&P, &most](int i, double by) {
    P(i, i) = std::max(P(i, i), std::min(most(i, i), P(i, i) + by * by));
  };
  if (of_scale) drift(0, drift_scale * x[0]);
  if (of_friction) drift(1, drift_excess);
  Matrix2d spread = told * P * told + told;
  spread.diagonal().array() += 1e-9 * spread.trace() + 1e-12;
  const bool off = pull.dot(spread.inverse() * pull) > surprise;
  // Where so much is new, what was known does not hold it back.
  if (off) P = 10 * most;

  if (!fuse(measured, weight, false, x, P)) return FitOutcome::unusable;
  if (!raise_by_sticking(measured, excess * base, x, P)) return FitOutcome::unusable;
  error_ = {x[0], x[1]};
  P_ = P;
  surprises_ += off ? 1 : 0;
  used_for_friction_ += of_friction ? 1 : 0;
  return FitOutcome::used;
}

FitOutcome ContactFit::take(Time valid, const LocalContacts& contacts, const BodyStates& bodies, bool massless,
                            const Wrench& contact_T_W, int touching) {
  if (any_ && valid <= last_) return FitOutcome::repeated;
  if (!is_scene(contacts, bodies, bodies.count)) return FitOutcome::unusable;
  Vector6 measured;
  measured << eigen(contact_T_W.force), eigen(rotates_ ? contact_T_W.torque : Vec3{});
  if (!std::isfinite(measured.squaredNorm())) return FitOutcome::unusable;
  Materials materials;
  if (touching <= 0 || collect(contacts, bodies, massless, materials) == 0) return FitOutcome::silent;
  measured.tail<3>() /= lever_;
  const ContactError known = error_;
  const Eigen::Matrix2d known_variance = P_;
  const bool foreign = any_ && !materials.any_of(materials_);
  if (foreign) {
    error_ = {};
    P_ = start_variance();
  }
  const FitOutcome outcome = update(measured);
  if (outcome != FitOutcome::used) {
    error_ = known;
    P_ = known_variance;
    return outcome;
  }
  any_ = true;
  last_ = valid;
  materials_ = materials;
  ++used_;
  resets_ += foreign ? 1 : 0;
  return FitOutcome::used;
}

void ContactFit::correct(LocalContacts& contacts) const {
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    if (!of_tool(contacts.pair[i])) continue;
    for (Contact& c : contacts.contact[i]) {
      if (!materials_.has({c.stiffness, c.damping, c.friction})) continue;
      c.stiffness *= error_.stiffness_scale;
      c.damping *= error_.stiffness_scale;
      c.friction = std::max(0.0, c.friction + error_.friction_excess);
    }
  }
}

}  // namespace tactor
