#include "nodes/own_physics/mujoco.hpp"

#include <algorithm>
#include <span>

#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

NodeInfo MujocoPhysics::declare() {
  Declare<MujocoPhysics> node("physics.mujoco", "MuJoCo moves the bodies, the tool among them on the coupling spring.");
  node.details(
          "The node loads a model of MuJoCo and moves it through every sample of the handle. It takes the place of "
          "collision and dynamics. The coupling is a part of MuJoCo's own equations: its spring and damper are rows of "
          "the constraint solver. They are solved together with the contacts, by implicit Euler, so a stiff coupling "
          "is stable at long sub-steps.\nThe scene of the graph needs no bodies: its tool and its gravity are then "
          "those "
          "of the model. A scene with a moving body has a tool of its own, which serves the coupling and the metrics. "
          "It "
          "has the mass of the model's tool, and turns (`motion: rigid`) if the model's tool has a free joint. Then "
          "its "
          "principal inertias are those of the model's tool, to 5 %, and the gravity of the scene is that of the "
          "model. "
          "Other moving bodies of the scene are found in the model by their names; the outputs `bodies` and `contacts` "
          "tell of these alone. Shapes and materials of the scene are not used.\nViews and pictures draw the geoms of "
          "the model, those of the groups 0 to 2.\nActuators keep the "
          "controls of `keyframe`. The "
          "integrator RK4 of a model is replaced by Euler, as `mj_step2` does. A run ends with an error if MuJoCo "
          "warns "
          "of an unstable scene, because MuJoCo resets such a scene silently.\nThe node needs the plugin "
          "tactor_mujoco.")
      .on_thread("physics")
      .input("device", &MujocoPhysics::device,
             {.doc = "every sample of the handle", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 4096}})
      .input("coupling", &MujocoPhysics::coupling, {.doc = "the spring and damper between handle and tool"})
      .refuses("coupling", "massless",
               "it needs a tool with mass, and that coupling has a massless tool; use a coupling with a damper")
      .output("state", &MujocoPhysics::state, "tool and handle at the time of the last sample used")
      .output("bodies", &MujocoPhysics::bodies, "the moving bodies of the scene at that time, the tool first")
      .output("contacts", &MujocoPhysics::contacts,
              "the contacts that MuJoCo found for the last sub-step, each with MuJoCo's law at its depth. Of a "
              "pyramidal cone creep and lift are left out")
      .output("engine", &MujocoPhysics::engine, "all that MuJoCo needs to go on from that time")
      .output("poses", &MujocoPhysics::poses, "where all moving bodies of the model are at that time, for views")
      .own_scene([](const Params& params) { return model_scene("physics.mujoco", params); },
                 [](const Params& params) { return model_tool("physics.mujoco", params); })
      .boolean("start_at_device", &Params::start_at_device, true,
               "start the tool at the handle's first pose, so that the spring is slack")
      .unneeded(nothing_moves)
      .role(Role::dynamics);
  declare_engine_model(node, true, 5e-4);
  node.coarser("substep", {1e-3, 2e-3, 5e-3})
      .metric("dynamics_steps", "1", "sub-steps", Better::neither,
              [](const MujocoPhysics& self) { return self.motion_.steps(); })
      .summed()
      .metric("dynamics_rejected_samples", "1", "samples of the handle that were not finite", Better::lower,
              [](const MujocoPhysics& self) { return self.gate_.refusals().refused(); })
      .summed()
      .metric("dynamics_dropped_states", "1", "results whose state was not sent, because readers held all arrays",
              Better::lower, &MujocoPhysics::dropped_states_)
      .summed();
  return node.info();
}

MujocoPhysics::MujocoPhysics(const Params& params, const NodeContext& context)
    : name_(context.name),
      start_at_device_(params.start_at_device),
      engine_(load_engine("physics.mujoco", params, context)),
      motion_(*engine_, params.substep),
      numbers_(engine_state_pool(*engine_, most_engine_states)),
      shown_(most_engine_states, std::max<std::size_t>(engine_->shown_bodies(), 1)) {
  note_untold(params, *engine_, context);
}

void MujocoPhysics::step(StepContext& context) {
  const Stamped<CouplingParameters>* spring = coupling.latest();
  if (spring == nullptr) return;
  if (spring->value.massless != 0) {
    throw RunError("node " + name_ +
                   ": physics.mujoco needs a tool with mass, and the coupling has a massless tool; use a coupling with "
                   "a damper");
  }
  bool moved = false;
  Stamped<DeviceState> sample;
  while (new_samples_.next(device, sample)) {
    if (!gate_.admit(sample)) continue;
    moved = true;
    if (!begun_) {
      if (start_at_device_) engine_->place_tool(sample.value.X_WD);
      motion_.begin(sample, spring->value);
      begun_ = true;
    } else if (!motion_.advance(sample, spring->value, contacts.wanted() ? &found_ : nullptr)) {
      throw RunError("node " + name_ + ": MuJoCo cannot go on at " + std::to_string(motion_.time().seconds()) +
                     " s: " + engine_->failure());
    }
  }
  if (!moved) return;
  context.add_work(engine_->tool().contacts);
  send();
}

void MujocoPhysics::send() {
  const Time time = motion_.time();
  state.send(time, motion_.tool_and_handle());
  if (bodies.wanted()) bodies.send(time, engine_->bodies());
  if (poses.wanted()) send_poses(time);
  if (contacts.wanted()) {
    // At the begin there has been no step yet.
    if (found_.bodies.count == 0) found_.bodies = engine_->bodies();
    contacts.send(time, found_);
  }
  if (!engine.wanted()) return;
  const std::optional<EngineState> sent = motion_.state(*numbers_, nullptr);
  if (sent) {
    engine.send(time, *sent);
  } else {
    ++dropped_states_;
  }
}

void MujocoPhysics::send_poses(Time time) {
  const auto sent = shown_.make(engine_->shown_bodies(), [this](std::span<ShownPose> all) { engine_->show(all); });
  // A view does without a picture.
  if (sent) poses.send(time, {*sent});
}

}  // namespace tactor
