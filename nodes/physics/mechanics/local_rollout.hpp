// Moves the bodies of a scene on from a physics result, against the contacts around them, with the device's motion.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "nodes/physics/contact/contact_source.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/physics/mechanics/patch_motion.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

/// A contact as a plane where the moving bodies are at `X_WB`, from what its anchors say:
///   distance = sum_j w_j d_j / sum_j w_j,   n = sum_j w_j n_j normalised,   w_j = 1 / (|x - x_j|^2 + (10 um)^2),
/// with x the contact point of anchor j now and x_j the same at the anchor. Each anchor gives the quadratic
///   d_j = distance_j + n_j . s + s . H_j s / 2,   s = x - x_j,   n_j' = n_j + H_j s,
/// over the anchors whose normals do not oppose that of the nearest (of a thin wall they may see either side), and with
/// H_j cut so that n_j turns by 0.3 rad at most: near edges curvature grows without bound, and a quadratic is
/// worth nothing beyond. So surfaces are known at each anchor, but for the ten-thousandth part that an anchor 1 mm away
/// has in the sum, and beside it as well as the quadratics know them: no worse than the worst of them. Between anchors
/// a surface that bends is followed where a plane would leave it. Of a ball that turns by a against what it touches the
/// contact point is taken along, which is wrong by some r a^2 / 2 (see Contact::H_W).
Contact contact_now(const LocalContacts& contacts, std::size_t i, const BodyStates& bodies);

/// True where these are `count` moving bodies at finite places, and contacts between bodies that there are.
bool is_scene(const LocalContacts& contacts, const BodyStates& bodies, int count);

/// The local rollout: dynamics' own step (RigidStep), from device sample to device sample, on the contacts that a
/// source finds where the bodies are, or else on the planes of contact_now. Where something deforms, the patch around
/// the tool (PatchMotion) is stepped together with the tool, and their contacts are found where both are. Allocates
/// nothing and throws nothing; its work is bounded by contacts, nodes and iterations.
class LocalRollout {
 public:
  /// `surface`: where contacts are found anew at each step; null: those of the model serve. It must outlive the
  /// rollout.
  /// `soft`: where contacts with what deforms are found, likewise; null in a scene where nothing does.
  explicit LocalRollout(const SystemModel& model, ContactSource* surface = nullptr, SoftContactSource* soft = nullptr);

  /// Why the model cannot be gone on from: it counts too many contacts, is not of this scene, or has bodies, a handle,
  /// a spring, a correction, a result or a patch that are not finite or out of range.
  [[nodiscard]] RefusalReason refusal(const LocalModel& model) const;
  /// Goes on from `model.bodies` at `model.time`, with the handle as `model.device` shows it. False, and nothing
  /// changes, where the model is refused.
  bool restart(const LocalModel& model);
  /// Takes what a later model knows, and leaves the bodies where they are. False, and nothing changes, as of restart.
  bool learn(const LocalModel& model);
  /// Moves the bodies on to the time of `sample` in one step; nothing happens where that is not later. False where the
  /// step did not converge: then the bodies are where a damped step has them, or where they were.
  bool advance(const Stamped<DeviceState>& sample);

  /// Where the rollout is, but for its patch, of which `patch` tells.
  [[nodiscard]] const LocalModel& model() const { return local_; }
  [[nodiscard]] const PatchMotion* patch() const { return patch_ && !patch_->empty() ? &*patch_ : nullptr; }
  [[nodiscard]] bool tool_rotates() const { return step_.model().body[0].rotates; }
  /// The tool and the handle, with the contacts' force of the last step.
  [[nodiscard]] PhysicsState state() const;
  /// m/s^2 and rad/s^2, of the tool over the last step, be it before the last restart.
  [[nodiscard]] const Twist& acceleration() const { return acceleration_; }
  /// m/s^2 and rad/s^2, of a tool that physics has in `state`, by weight, spring and contacts; zero without inertia.
  [[nodiscard]] Twist acceleration_of(const PhysicsState& state, const CouplingParameters& coupling) const;
  /// How far the tool is from where its surroundings are known, m: from the nearest anchor of the contacts, where the
  /// last step was on those, and from where the result has it, where there is a patch, which was made around that.
  /// Zero where neither is.
  [[nodiscard]] double distance_from_known() const;
  /// Whether the last step found its contacts on the surface.
  [[nodiscard]] bool on_surface() const { return on_surface_; }
  /// How the wrench on the device changes with the handle's place (m and rotation vector in rad, W) where springs
  /// balance: -K (1 - (K + C)^-1 K), with K the coupling and C the planes that push, friction left out. Of the tool
  /// alone; where it does not rotate, of forces alone. Zero where
  /// contacts of absurd numbers make none.
  [[nodiscard]] Eigen::Matrix<double, 6, 6> jacobian();

 private:
  [[nodiscard]] bool fits_scene(const LocalModel& model) const;
  StepResult advance_with_patch(const DeviceState& device, const ContactPlanes& planes, double h);
  ContactPlanes planes_now();
  ContactPlanes anchored_planes();

  int bodies_;  // moving ones
  RigidStep step_;
  ContactSource* surface_;
  SoftContactSource* soft_;
  std::optional<PatchMotion> patch_;  // of scenes where something deforms
  std::vector<SoftContact> touched_;  // what of it the tool is near to
  bool on_surface_ = false;
  ContactSet found_;
  LocalModel local_;
  std::array<Pose, BodyStates::capacity> X_WB_;  // of the bodies, for the planes
  std::array<Contact, LocalContacts::capacity> planes_;
  StepResult last_{.outcome = StepOutcome::converged};
  Twist acceleration_;
};

}  // namespace tactor
