#include "nodes/physics/mechanics/local_rollout.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include "framework/core/handle_gate.hpp"

#include <Eigen/Cholesky>

#include "nodes/physics/contact/moved_on.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/free_rotation.hpp"

namespace tactor {

namespace {

constexpr double most_bend = 0.3;     // rad, of an anchor's normal by its curvature
constexpr double near_anchor = 1e-5;  // m

/// Of springs, dampers and scales: beyond, forces overflow.
constexpr double largest = 1e12;

/// A comparison with NaN is false.
bool fits(double x) {
  return x >= 0 && x <= largest;
}

bool usable(const ContactCorrection& c) {
  return c.count >= 0 && c.count <= ContactCorrection::most_materials && fits(c.scale_all) &&
         fits(c.friction_scale_all) && fits(c.stiffness_scale) && std::abs(c.friction_excess) <= largest;
}

bool finite(const BodyStates& bodies) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(bodies.count); ++i) {
    const Pose& X = bodies.X_WB[i];
    const Twist& V = bodies.V_WB[i];
    const double length = X.R.w * X.R.w + X.R.x * X.R.x + X.R.y * X.R.y + X.R.z * X.R.z;
    // A comparison with NaN is false.
    if (!is_finite(X.p) || !is_finite(V.v) || !is_finite(V.w) || !(length > 0.25 && length < 4)) return false;
  }
  return true;
}

Vec3 times(const std::array<double, 6>& H, const Vec3& s) {
  return {H[0] * s.x + H[1] * s.y + H[2] * s.z, H[1] * s.x + H[3] * s.y + H[4] * s.z,
          H[2] * s.x + H[4] * s.y + H[5] * s.z};
}

/// What an anchor says of a contact where the bodies are now.
struct AtAnchor {
  double share = 0;  // of the mean
  double distance = 0;
  Vec3 n, p_W;
};

AtAnchor at_anchor(const LocalContacts& contacts, std::size_t i, std::size_t j, const BodyStates& bodies) {
  const Contact& c = contacts.contact[i][j];
  const ContactPair& pair = contacts.pair[i];
  const std::span X_query(contacts.X_WB[j]);
  const PlaneNow plane =
      plane_now({X_query.first(static_cast<std::size_t>(contacts.bodies)), {&c, 1}, {&pair, 1}}, 0, bodies.X_WB);
  // The way of the contact point, seen from the other body.
  Vec3 x_then = transform(X_query[static_cast<std::size_t>(pair.body)], c.p_TC);
  Quat turn;
  if (pair.other != ContactPair::fixed) {
    const auto other = static_cast<std::size_t>(pair.other);
    const Pose motion = bodies.X_WB[other] * inverse(X_query[other]);
    x_then = transform(motion, x_then);
    turn = motion.R;
  }
  const Vec3 way = plane.p_W - x_then;
  Vec3 bend = rotate(turn, times(c.H_W, rotate(inverse(turn), way)));
  const double angle = norm(bend);
  if (!(angle <= most_bend)) bend = std::isfinite(angle) ? (most_bend / angle) * bend : Vec3{};
  return {1 / (dot(way, way) + near_anchor * near_anchor), plane.distance + 0.5 * dot(way, bend), plane.n_W + bend,
          plane.p_W};
}

}  // namespace

Contact contact_now(const LocalContacts& contacts, std::size_t i, const BodyStates& bodies) {
  const auto anchors = static_cast<std::size_t>(contacts.anchors);
  std::array<AtAnchor, LocalContacts::max_anchors> at;
  std::size_t nearest = 0;
  for (std::size_t j = 0; j < anchors; ++j) {
    at[j] = at_anchor(contacts, i, j, bodies);
    if (at[j].share > at[nearest].share) nearest = j;
  }
  double sum = 0, distance = 0, weight = 0;
  Vec3 n, p_W;
  for (std::size_t j = 0; j < anchors; ++j) {
    // Of a thin wall anchors may see either side.
    if (dot(at[j].n, at[nearest].n) < 0) continue;
    const double share = at[j].share;
    sum += share;
    distance += share * at[j].distance;
    weight += share * contacts.contact[i][j].weight;
    n += share * at[j].n;
    p_W += share * at[j].p_W;
  }
  Contact result = contacts.contact[i][0];
  result.n_W = (1 / norm(n)) * n;
  result.distance = distance / sum;
  result.weight = weight / sum;
  result.p_TC = transform(inverse(bodies.X_WB[static_cast<std::size_t>(contacts.pair[i].body)]), (1 / sum) * p_W);
  return result;
}

bool is_scene(const LocalContacts& contacts, const BodyStates& bodies, int count) {
  const bool ours = count >= 1 && count <= BodyStates::capacity && bodies.count == count && contacts.count >= 0 &&
                    contacts.count <= LocalContacts::capacity &&
                    (contacts.count == 0 || (contacts.bodies == count && contacts.anchors >= 1 &&
                                             contacts.anchors <= LocalContacts::max_anchors));
  if (!ours || !finite(bodies)) return false;
  const auto foreign = [count](const ContactPair& pair) {
    return pair.body < 0 || pair.body >= count || pair.other < ContactPair::fixed || pair.other >= count;
  };
  const std::span pairs = std::span(contacts.pair).first(static_cast<std::size_t>(contacts.count));
  return std::none_of(pairs.begin(), pairs.end(), foreign);
}

LocalRollout::LocalRollout(const SystemModel& model, ContactSource* surface, SoftContactSource* soft)
    : bodies_(model.count), step_(model, soft == nullptr ? 0 : LocalPatch::capacity), surface_(surface), soft_(soft) {
  if (soft == nullptr) return;
  patch_.emplace(model.integrator);
  touched_.reserve(ContactSet::capacity);
}

RefusalReason LocalRollout::refusal(const LocalModel& model) const {
  if (model.contacts.count < 0 || model.contacts.count > LocalContacts::capacity) return RefusalReason::too_many;
  const bool finite_parts = is_usable(model.device) && is_usable(model.coupling) && usable(model.correction) &&
                            is_finite(model.p_WT_result) && is_finite(model.wrench_result) && is_usable(model.patch);
  if (!finite_parts || (model.bodies.count == bodies_ && !finite(model.bodies))) return RefusalReason::not_finite;
  return is_scene(model.contacts, model.bodies, bodies_) && fits_scene(model) ? RefusalReason::none
                                                                              : RefusalReason::another_scene;
}

/// Whether its patch is of the bodies that deform here. A patch cannot be stepped with a massless tool.
bool LocalRollout::fits_scene(const LocalModel& model) const {
  if (model.patch.nodes.empty()) return true;
  if (!patch_ || model.coupling.massless != 0) return false;
  return std::all_of(model.patch.faces.begin(), model.patch.faces.end(),
                     [this](const PatchFace& face) { return face.body < soft_->deformable(); });
}

bool LocalRollout::restart(const LocalModel& model) {
  if (refusal(model) != RefusalReason::none) return false;
  local_ = model;
  if (patch_) patch_->restart(model.patch);
  last_ = {};
  return true;
}

bool LocalRollout::learn(const LocalModel& model) {
  if (refusal(model) != RefusalReason::none || (patch() != nullptr && model.coupling.massless != 0)) return false;
  local_.coupling = model.coupling;
  local_.contacts = model.contacts;
  local_.correction = model.correction;
  return true;
}

/// The contacts where the bodies are now; they refer to what the rollout keeps.
ContactPlanes LocalRollout::planes_now() {
  on_surface_ = surface_ != nullptr && local_.contacts_told == 0 && surface_->find(local_.bodies, found_);
  if (!on_surface_) return anchored_planes();
  for (std::size_t i = 0; i < static_cast<std::size_t>(found_.count); ++i) {
    local_.correction.apply(found_.contact[i], found_.pair[i]);
  }
  return contact_planes(found_);
}

/// The model's contacts as planes where the bodies are now.
ContactPlanes LocalRollout::anchored_planes() {
  const auto count = static_cast<std::size_t>(local_.contacts.count);
  X_WB_ = local_.bodies.X_WB;
  for (std::size_t i = 0; i < count; ++i) {
    planes_[i] = contact_now(local_.contacts, i, local_.bodies);
    local_.correction.apply(planes_[i], local_.contacts.pair[i]);
  }
  return {std::span(X_WB_).first(static_cast<std::size_t>(bodies_)), std::span(planes_).first(count),
          std::span(local_.contacts.pair).first(count)};
}

bool LocalRollout::advance(const Stamped<DeviceState>& sample) {
  const double h = (sample.stamp.valid - local_.time).seconds();
  if (h <= 0) return true;
  const Twist V0 = local_.bodies.V_WB[0];
  const ContactPlanes planes = planes_now();
  last_ = patch() == nullptr ? step_.advance(local_.coupling, local_.device, sample.value, planes, h, local_.bodies)
                             : advance_with_patch(sample.value, planes, h);
  const Twist& V1 = local_.bodies.V_WB[0];
  acceleration_ = {(1 / h) * (V1.v - V0.v), (1 / h) * (V1.w - V0.w)};
  local_.device = sample.value;
  local_.time = sample.stamp.valid;
  return last_.outcome == StepOutcome::converged;
}

StepResult LocalRollout::advance_with_patch(const DeviceState& device, const ContactPlanes& planes, double h) {
  StepResult result{.outcome = StepOutcome::stopped};
  // Contacts are found where their forces act. Where the step begins, normals of a tool that slides would be a tick
  // old.
  const BodyStates ahead = moved_on(local_.bodies, patch_->solved_time(h));
  // Without its contacts the tool would go through the patch.
  if (!soft_->find_on(patch_->faces(), patch_->nodes_ahead_W(h), ahead.X_WB[0], touched_)) return result;
  if (touched_.empty()) {
    patch_->coast(h);
    return step_.advance(local_.coupling, local_.device, device, planes, h, local_.bodies);
  }
  const SoftPatch patch = patch_->begin(h, touched_, std::span(ahead.X_WB).first(static_cast<std::size_t>(bodies_)));
  result = step_.advance(patch, local_.coupling, local_.device, device, planes, h, local_.bodies, patch_->motion());
  if (result.outcome == StepOutcome::converged) patch_->end(h);
  return result;
}

PhysicsState LocalRollout::state() const {
  return {.X_WT = local_.bodies.X_WB[0],
          .V_WT = local_.bodies.V_WB[0],
          .X_WD = local_.device.X_WD,
          .V_WD = local_.device.V_WD,
          .contact_T_W = last_.contact_T_W,
          .contacts = last_.touching,
          .damped = last_.outcome == StepOutcome::converged ? 0 : 1};
}

Twist LocalRollout::acceleration_of(const PhysicsState& state, const CouplingParameters& coupling) const {
  if (coupling.massless != 0) return {};
  const BodyModel& tool = step_.model().body[0];
  const CouplingParameters unlimited{.k_t = coupling.k_t,
                                     .b_t = coupling.b_t,
                                     .k_r = coupling.k_r,
                                     .b_r = coupling.b_r,
                                     .force_max = largest,
                                     .torque_max = largest};
  const Wrench sum = state.contact_T_W - coupling_wrench(unlimited, state, tool.rotates);
  Twist acceleration{step_.model().gravity_W + (1 / tool.mass) * sum.force, {}};
  if (tool.rotates) {
    const Eigen::Matrix3d inertia = inertia_W(tool.inertia_B, state.X_WT.R);
    const Eigen::Vector3d w = eigen(state.V_WT.w), spin = inertia * w;
    acceleration.w = plain(inertia.ldlt().solve(eigen(sum.torque) - w.cross(spin)));
  }
  return acceleration;
}

double LocalRollout::distance_from_known() const {
  const LocalContacts& contacts = local_.contacts;
  const Vec3& p_WT = local_.bodies.X_WB[0].p;
  double nearest = 0;
  for (std::size_t j = 0; !on_surface_ && j < static_cast<std::size_t>(contacts.anchors); ++j) {
    const double away = norm(p_WT - contacts.X_WB[j][0].p);
    nearest = j == 0 ? away : std::min(nearest, away);
  }
  return patch() == nullptr ? nearest : std::max(nearest, norm(p_WT - local_.p_WT_result));
}

Eigen::Matrix<double, 6, 6> LocalRollout::jacobian() {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  Matrix6 K = Matrix6::Zero();
  K.diagonal() << Eigen::Vector3d::Constant(local_.coupling.k_t), Eigen::Vector3d::Constant(local_.coupling.k_r);
  Matrix6 C = Matrix6::Zero();
  const ContactPlanes planes = planes_now();
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    const Contact& c = planes.planes[i];
    if (planes.pairs[i].body != 0 || !usable(planes, i, bodies_) || !(c.distance < 0)) continue;
    const Pose& X_WT = local_.bodies.X_WB[0];
    // A body that does not rotate has no levers.
    const Vec3 lever = step_.model().body[0].rotates ? transform(X_WT, c.p_TC) - X_WT.p : Vec3{};
    Eigen::Matrix<double, 6, 1> push;
    push << eigen(c.n_W), eigen(cross(lever, c.n_W));
    C += c.weight * c.stiffness * push * push.transpose();
  }
  // What has no spring (rotation in a scene without) stays out of the balance.
  Matrix6 sum = K + C;
  sum.diagonal().array() += 1e-12 * (1 + sum.trace());
  const Matrix6 J = -K + K * sum.ldlt().solve(K);
  return J.allFinite() ? J : Matrix6(Matrix6::Zero());
}

}  // namespace tactor
