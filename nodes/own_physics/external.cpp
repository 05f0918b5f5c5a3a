#include "nodes/own_physics/external.hpp"

namespace tactor {

NodeInfo ExternalPhysics::declare() {
  return Declare<ExternalPhysics>("physics.external",
                                  "Physics that a program runs itself, with a simulator of its own.")
      .details(
          "A program steps it by a PhysicsLoop, in C++ or in Python. The loop gives the handle and the coupling for "
          "each "
          "step, and takes the tool's pose, the contacts and the force that the step came to. The graph reads them "
          "here "
          "as it reads those of dynamics. Under the virtual clock, a result becomes visible one period of `rate` after "
          "its step began, however long the program took. With `clock: real`, it becomes visible when the program "
          "sends "
          "it. A run that no program steps gets no results.")
      .role(Role::dynamics)
      .fed()
      .input("device", &ExternalPhysics::device,
             {.doc = "the handle, for the program's physics", .queue = {QueuePolicy::drop_oldest, 4096}})
      .input(
          "coupling", &ExternalPhysics::coupling,
          {.doc = "the spring and damper between handle and tool, for the program's physics; without this input, the "
                  "program has a coupling of its own and says what is felt",
           .required = false})
      .refuses("coupling", "massless",
               "a program's tool has a mass, and that coupling has a massless tool; use a coupling with a damper")
      .output("state", &ExternalPhysics::state, "tool and handle at the time of the result")
      .output("bodies", &ExternalPhysics::bodies, "all moving bodies of the scene at that time, the tool first")
      .output("contacts", &ExternalPhysics::contacts, "the contacts that the program tells, at that time")
      .output("force", &ExternalPhysics::force, "wrench on the device about its handle, where the program says it")
      .output("engine", &ExternalPhysics::engine,
              "the state of the program's light copy at that time, where the program tells it (PhysicsLoop::rollout, "
              "in C++)")
      .real("rate", &Params::rate,
            {.doc = "steps per second. Live, a program that takes longer than a period steps as often as it can",
             .unit = "Hz",
             .default_value = 100,
             .min = 0.1,
             .max = 1e5})
      .info();
}

}  // namespace tactor
