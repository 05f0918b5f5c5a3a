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

SystemModel model_of(const RigidDynamics::Params& params, const Scene& scene, Notes* notes) {
  SystemModel model;
  model.count = 0;
  for (const std::size_t i : scene.moving()) {
    const Body& body = scene.bodies[i];
    BodyModel& m = model.body[static_cast<std::size_t>(model.count++)];
    m.mass = body.mass;
    m.rotates = body.motion == Motion::rigid;
    if (m.rotates) m.inertia_B = body_inertia(body, notes);
  }
  if (model.count == 0) throw InputError("dynamics.rigid needs a moving body in the scene");
  model.gravity_W = scene.gravity_W;
  model.iterations = params.iterations;
  model.stick_velocity = params.stick_velocity;
  return model;
}

}  // namespace

RigidDynamics::RigidDynamics(const Params& params, const NodeContext& context)
    : params_(params), solver_(model_of(params, *context.scene, context.notes)) {
  for (const std::size_t i : context.scene->moving()) {
    bodies_.X_WB[static_cast<std::size_t>(bodies_.count++)] = context.scene->bodies[i].X_WB;
  }
}

void RigidDynamics::step(StepContext& context) {
  const Stamped<CouplingLaw>* spring = law.latest();
  if (spring == nullptr) return;
  const Stamped<ContactSet>* set = contacts.connected() ? contacts.latest() : nullptr;
  ContactPlanes planes;
  if (set != nullptr) planes = contact_planes(set->value);
  Time until = context.now();
  if (set != nullptr && params_.advance_to == AdvanceTo::contacts) until = std::min(until, set->stamp.valid);

  bool moved = false;
  while (take_sample(until)) {
    if (begun_) {
      advance(sample_, spring->value, planes);
    } else {
      begin(sample_);
      // The query was made before the tool had its place.
      if (params_.start_at_device) planes = {};
    }
    moved = true;
  }
  if (!moved) return;
  state.send(used_.stamp.valid, {.X_WT = bodies_.X_WB[0],
                                 .V_WT = bodies_.V_WB[0],
                                 .X_WD = used_.value.X_WD,
                                 .V_WD = used_.value.V_WD,
                                 .contact_T_W = last_.contact_T_W,
                                 .contacts = last_.touching});
  bodies.send(used_.stamp.valid, bodies_);
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
  bodies_.X_WB[0].p = sample.value.X_WD.p;
  if (rotates()) bodies_.X_WB[0].R = sample.value.X_WD.R;
}

void RigidDynamics::advance(const Stamped<DeviceState>& sample, const CouplingLaw& spring,
                            const ContactPlanes& planes) {
  const double interval = (sample.stamp.valid - used_.stamp.valid).seconds();
  if (interval > 0) {
    // The small allowance keeps an interval of exactly n sub-steps at n.
    const auto count = static_cast<std::int64_t>(std::max(1.0, std::ceil(interval / params_.substep - 1e-6)));
    const double h = interval / static_cast<double>(count);
    DeviceState before = used_.value;
    for (std::int64_t i = 1; i <= count; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(count);
      const DeviceState after = between(used_.value, sample.value, share, rotates());
      last_ = solver_.advance(spring, before, after, planes, h, bodies_);
      before = after;
      ++steps_;
      if (last_.outcome == StepOutcome::damped) ++damped_;
      if (last_.outcome == StepOutcome::stopped) ++stopped_;
      left_out_ += last_.left_out;
    }
  }
  used_ = sample;
}

void RigidDynamics::report(Report& report) const {
  report.add("dynamics_steps", static_cast<double>(steps_));
  report.add("dynamics_damped_steps", static_cast<double>(damped_));
  report.add("dynamics_stopped_steps", static_cast<double>(stopped_));
  report.add("dynamics_contacts_left_out", static_cast<double>(left_out_));
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
      .output("bodies", &RigidDynamics::bodies, "all moving bodies at that time, the tool first")
      .real("substep", &Params::substep,
            {.doc = "longest sub-step", .unit = "s", .default_value = 0.001, .min = 1e-6, .max = 0.01})
      .integer("iterations", &Params::iterations,
               {.doc = "Newton iterations a sub-step, at most", .default_value = 60, .min = 1, .max = 200})
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
