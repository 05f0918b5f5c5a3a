#include "nodes/source/physics.hpp"

namespace tactor {

NodeInfo PhysicsSource::declare() {
  return Declare<PhysicsSource>("source.physics", "Shows a recorded force as slowly and as late as physics would.")
      .details(
          "Use it in place of collision, dynamics and coupling if the true force is known from a recording. With a "
          "`cost` of 7 to 20 ms it takes the newest force, shows it one such period later with its original stamp, and "
          "takes the next. `sink.metrics` then compares with the recording itself, because reference runs have no "
          "costs.")
      .input("recorded", &PhysicsSource::recorded,
             {.doc = "the true force, at a higher rate", .trigger = Trigger::yes, .queue = {QueuePolicy::latest, 1}})
      .output("force", &PhysicsSource::force, "the newest of these forces")
      .role(Role::source)
      .info();
}

void PhysicsSource::step(StepContext&) {
  Stamped<Wrench> newest;
  if (new_recorded_.next(recorded, newest)) force.send(newest.stamp.valid, newest.value);
}

}  // namespace tactor
