#include "bench/collision/physics_rig.hpp"

#include "framework/core/check.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::bench {

namespace {

NodeContext context_of(const Scene& scene) {
  return {.name = "bench", .scene = &scene, .torque = scene.rotates()};
}

RigidDynamics::Params params_of(Start start) {
  auto params = test::default_params<RigidDynamics>();
  params.start_at_device = start == Start::at_handle;
  return params;
}

}  // namespace

Scene two_of(const std::filesystem::path& mesh) {
  tactor::Body fixed;
  fixed.name = "fixed body";
  fixed.shape = MeshShape{mesh};
  fixed.material = {.stiffness = 2000, .damping = 2, .friction = 0.3, .patch_area = 0.4e-4};
  tactor::Body tool = fixed;
  tool.name = "tool";
  tool.motion = Motion::rigid;
  tool.mass = 0.1;
  Scene scene;
  scene.gravity_W = {};
  scene.bodies = {fixed, tool};
  return scene;
}

Pose balancing_handle(const CouplingParameters& coupling, const Pose& X_WT, const ContactSet& set) {
  Vec3 force, torque;
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    if (c.distance >= 0) continue;
    const Vec3 push = -c.weight * c.stiffness * c.distance * c.n_W;
    force += push;
    torque += cross(rotate(X_WT.R, c.p_TC), push);
  }
  return {X_WT.p - force / coupling.k_t, from_rotation_vector(-torque / coupling.k_r) * X_WT.R};
}

DynamicsRig::DynamicsRig(const Scene& scene, Start start)
    : context_(context_of(scene)),
      dynamics_(params_of(start), context_),
      coupling_(test::default_params<AdaptiveCoupling>(), context_) {
  dynamics_.contacts.configure({});
  dynamics_.device.configure({QueuePolicy::drop_oldest, 4096});
  dynamics_.coupling.configure({});
  coupling_.state.configure({});
  StepContext context{Time{}};
  coupling_.start(context);
  parameters_ = test::sent(coupling_.parameters);
  dynamics_.coupling.push({}, &parameters_);
}

const PhysicsState& DynamicsRig::advance(Time t, const DeviceState& device, const ContactSet& set) {
  now_ = t;
  dynamics_.contacts.push({t, t, 0}, &set);
  dynamics_.device.push({t, t, 0}, &device);
  dynamics_.state.clear_pending();
  dynamics_.bodies.clear_pending();
  StepContext context(t);
  dynamics_.step(context);
  TACTOR_DEMAND(dynamics_.state.pending() == 1);
  return state_ = test::sent(dynamics_.state);
}

const Wrench& DynamicsRig::force() {
  coupling_.state.push({now_, now_, 0}, &state_);
  coupling_.force.clear_pending();
  StepContext context(now_);
  coupling_.step(context);
  return test::sent(coupling_.force);
}

DeviceState device_at(const Pose& X_WD, const Pose& before, double period) {
  return {.X_WD = X_WD,
          .V_WD = {(X_WD.p - before.p) / period, to_rotation_vector(X_WD.R * inverse(before.R)) / period}};
}

}  // namespace tactor::bench
