#include "nodes/source/physics.hpp"

namespace tactor {

NodeInfo PhysicsSource::declare() {
  return Declare<PhysicsSource>("source.physics", "Shows a recorded force as slow and late as physics would.")
      .details(
          "Stands for collision, dynamics and coupling where the true force is known from a recording: with a `cost` "
          "of "
          "7 to 20 ms it takes the newest force, shows it one such period later with the stamp it came with, and takes "
          "the next. What `sink.metrics` judges against is then the recording itself, because reference runs have no "
          "costs.")
      .input("recorded", &PhysicsSource::recorded,
             {.doc = "the true force, at a higher rate", .trigger = Trigger::yes, .queue = {QueuePolicy::latest, 1}})
      .output("force", &PhysicsSource::force, "the newest of them")
      .role(Role::source)
      .info();
}

void PhysicsSource::step(StepContext&) {
  Stamped<Wrench> newest;
  if (new_recorded_.next(recorded, newest)) force.send(newest.stamp.valid, newest.value);
}

}  // namespace tactor
