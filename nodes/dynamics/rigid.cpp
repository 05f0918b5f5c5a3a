#include "nodes/dynamics/rigid.hpp"

#include <algorithm>

#include "framework/node/declare.hpp"
#include "nodes/scene/body_mesh.hpp"

namespace tactor {

namespace {

bool usable(const DeviceState& s) {
  const Quat& q = s.X_WD.R;
  const double length = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return is_finite(s.X_WD.p) && is_finite(s.V_WD.v) && is_finite(s.V_WD.w) && std::isfinite(length) && length > 0.25;
}

/// The handle at share s of the way from a to b: steady motion along the line and about the shorter turn.
DeviceState between(const DeviceState& a, const DeviceState& b, double s, bool rotates) {
  DeviceState d = b;
  d.X_WD.p = a.X_WD.p + s * (b.X_WD.p - a.X_WD.p);
  d.V_WD.v = a.V_WD.v + s * (b.V_WD.v - a.V_WD.v);
  if (rotates) {
    const Vec3 turn = to_rotation_vector(b.X_WD.R * inverse(a.X_WD.R));
    d.X_WD.R = from_rotation_vector(s * turn) * a.X_WD.R;
    d.V_WD.w = a.V_WD.w + s * (b.V_WD.w - a.V_WD.w);
  }
  return d;
}

}  // namespace

RigidDynamics::RigidDynamics(const Params& params, const NodeContext& context) : params_(params) {
  const Body* tool = context.scene->tool();
  if (tool == nullptr) throw InputError("dynamics.rigid needs a moving body in the scene");
  model_.mass = tool->mass;
  model_.inertia_T = context.torque ? body_inertia(*tool, context.notes) : Eigen::Matrix3d::Zero();
  model_.gravity_W = context.scene->gravity_W;
  model_.rotates = context.torque;
  model_.iterations = params.iterations;
  model_.stick_velocity = params.stick_velocity;
  tool_.X_WT = tool->X_WB;
}

void RigidDynamics::step(StepContext& context) {
  const Stamped<CouplingLaw>* spring = law.latest();
  if (spring == nullptr) return;
  const Stamped<ContactSet>* set = contacts.connected() ? contacts.latest() : nullptr;
  ContactPlanes planes;
  if (set != nullptr) {
    planes.X_WT = set->value.bodies.X_WB[0];
    planes.planes = std::span(set->value.contact.data(), static_cast<std::size_t>(set->value.count));
  }
  Time until = context.now();
  if (set != nullptr && params_.advance_to == AdvanceTo::contacts) until = std::min(until, set->stamp.valid);

  bool moved = false;
  while (take_sample(until)) {
    if (begun_) {
      advance(sample_, spring->value, planes);
    } else {
      begin(sample_);
      // The query was made before the tool had its place.
      if (params_.start_at_device) planes.planes = {};
    }
    moved = true;
  }
  if (!moved) return;
  state.send(used_.stamp.valid, {.X_WT = tool_.X_WT,
                                 .V_WT = tool_.V_WT,
                                 .X_WD = used_.value.X_WD,
                                 .V_WD = used_.value.V_WD,
                                 .contact_T_W = last_.contact_T_W,
                                 .contacts = last_.touching});
}

/// Puts the next usable sample up to `until` into `sample_`; a later one stays for the next step.
bool RigidDynamics::take_sample(Time until) {
  for (;;) {
    if (!waiting_ && !device.pop(sample_)) return false;
    waiting_ = true;
    if (sample_.stamp.valid > until) return false;
    waiting_ = false;
    if (usable(sample_.value)) {
      sample_.value.X_WD.R = normalized(sample_.value.X_WD.R);
      return true;
    }
    ++rejected_;
  }
}

void RigidDynamics::begin(const Stamped<DeviceState>& sample) {
  begun_ = true;
  used_ = sample;
  if (!params_.start_at_device) return;
  tool_.X_WT.p = sample.value.X_WD.p;
  if (model_.rotates) tool_.X_WT.R = sample.value.X_WD.R;
}

void RigidDynamics::advance(const Stamped<DeviceState>& sample, const CouplingLaw& spring,
                            const ContactPlanes& planes) {
  const double interval = (sample.stamp.valid - used_.stamp.valid).seconds();
  if (interval > 0) {
    // The small allowance keeps an interval of exactly n sub-steps at n.
    const auto count = static_cast<std::int64_t>(std::max(1.0, std::ceil(interval / params_.substep - 1e-6)));
    const double h = interval / static_cast<double>(count);
    for (std::int64_t i = 1; i <= count; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(count);
      last_ = rigid_step(model_, spring, between(used_.value, sample.value, share, model_.rotates), planes, h, tool_);
      if (!last_.solved) ++fallbacks_;
      if (last_.solved && !last_.converged) ++unconverged_;
    }
  }
  used_ = sample;
}

void RigidDynamics::report(Report& report) const {
  report.add("dynamics_fallbacks", static_cast<double>(fallbacks_));
  report.add("dynamics_unconverged", static_cast<double>(unconverged_));
  report.add("dynamics_rejected_samples", static_cast<double>(rejected_));
}

NodeInfo RigidDynamics::declare() {
  return Declare<RigidDynamics>("dynamics.rigid", "The tool as a rigid body on the coupling spring, with contacts.")
      .on_thread("physics")
      .details(
          "Implicit Euler in the coupling, the contacts' stiffness, damping and friction, and the gyroscopic term, "
          "sub-stepped through every device sample since the last step. Stable at any stiffness and mass; it adds "
          "numerical damping of the order of the sub-step. The tool feels the true spring, the device the one limited "
          "to force_max. In a scene that only translates no rotation is computed.")
      .input("contacts", &RigidDynamics::contacts,
             {.doc = "contact planes of the last query", .trigger = Trigger::yes, .required = false})
      .input("device", &RigidDynamics::device,
             {.doc = "every sample of the handle",
              .trigger = Trigger::when_alone,
              .queue = {QueuePolicy::drop_oldest, 4096}})
      .input("law", &RigidDynamics::law, {.doc = "the spring and damper between handle and tool"})
      .output("state", &RigidDynamics::state, "tool and handle at the time of the last sample used")
      .real("substep", &Params::substep,
            {.doc = "longest sub-step", .unit = "s", .default_value = 0.001, .min = 1e-6, .max = 0.01})
      .integer("iterations", &Params::iterations,
               {.doc = "Newton iterations a sub-step, at most", .default_value = 4, .min = 1, .max = 50})
      .real("stick_velocity", &Params::stick_velocity,
            {.doc = "sliding speed below which friction is viscous",
             .unit = "m/s",
             .default_value = 0.0005,
             .min = 0,
             .max = 1,
             .above_min = true})
      .choice("advance_to", &Params::advance_to, {{"contacts", AdvanceTo::contacts}, {"now", AdvanceTo::now}},
              std::optional(AdvanceTo::contacts),
              "how far to simulate: to the time the contact query began, or to the newest sample")
      .boolean("start_at_device", &Params::start_at_device, true,
               "start the tool at the handle's first pose, so that the spring is slack")
      .check_bodies([](const Scene& scene, Notes* notes) {
        if (scene.rotates()) body_inertia(*scene.tool(), notes);
      })
      .unneeded([](const Scene& scene) {
        return scene.tool() == nullptr ? std::string("nothing in the scene moves") : std::string();
      })
      .info();
}

}  // namespace tactor
