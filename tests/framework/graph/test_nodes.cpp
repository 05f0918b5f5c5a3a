#include "test_nodes.hpp"
#include "nodes/prediction/ar_coefficients.hpp"

#include <fstream>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"

namespace tactor::testing {

namespace fs = std::filesystem;

namespace {

// Nothing here is ever stepped.
class Idle : public Node {
 public:
  void step(StepContext&) override {}
};

struct Device final : Idle {
  struct Params {
    double rate = 0, encoder_step = 0;
  };
  Device(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Device>("test.device", "A device.")
        .realtime_safe()
        .input("segment", &Device::segment, {.required = false})
        .output("state", &Device::state, "")
        .output("commanded", &Device::commanded, "")
        .haptic_rate(&Params::rate, {.doc = "steps", .in_reference = 10000})
        .real("encoder_step", &Params::encoder_step,
              {.doc = "step", .unit = "m", .default_value = 1e-5, .min = 0, .in_reference = 0.0})
        .info();
  }
  Input<ForceSegment> segment;
  Output<DeviceState> state;
  Output<Wrench> commanded;
};

struct Collision final : Idle {
  struct Params {
    double margin = 0;
  };
  Collision(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Collision>("test.collision", "Contacts.")
        .unneeded([](const Scene& scene) {
          for (const Body& body : scene.bodies) {
            if (body.motion == Motion::fixed) return std::string();
          }
          return std::string("the scene has nothing to hit");
        })
        .input("device", &Collision::device, {.trigger = Trigger::yes})
        .input("state", &Collision::state, {.required = false})
        .output("contacts", &Collision::contacts, "")
        .real("margin", &Params::margin, {.doc = "reach", .unit = "m", .default_value = 1e-3, .min = 0, .max = 0.1})
        .role(Role::collision)
        .info();
  }
  Input<DeviceState> device;
  Input<PhysicsState> state;
  Output<ContactSet> contacts;
};

struct Dynamics final : Idle {
  enum class Until { contacts, now };
  struct Params {
    Until advance_to = Until::contacts;
  };
  Dynamics(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Dynamics>("test.dynamics", "The tool's motion.")
        .input("contacts", &Dynamics::contacts, {.trigger = Trigger::yes, .required = false})
        .input("device", &Dynamics::device, {.trigger = Trigger::when_alone, .queue = {QueuePolicy::drop_oldest, 4096}})
        .input("coupling", &Dynamics::coupling, {})
        .output("state", &Dynamics::state, "")
        .choice("advance_to", &Params::advance_to, {{"contacts", Until::contacts}, {"now", Until::now}},
                std::optional(Until::contacts), "how far")
        .info();
  }
  Input<ContactSet> contacts;
  Input<DeviceState> device;
  Input<CouplingParameters> coupling;
  Output<PhysicsState> state;
};

struct Coupling final : Idle {
  struct Params {
    double stiffness = 0;
  };
  Coupling(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Coupling>("test.coupling", "A spring.")
        .input("state", &Coupling::state, {.trigger = Trigger::yes})
        .output("force", &Coupling::force, "")
        .output("parameters", &Coupling::parameters, "")
        .real("stiffness", &Params::stiffness, {.doc = "of the spring", .unit = "N/m", .min = 0, .above_min = true})
        .info();
  }
  Input<PhysicsState> state;
  Output<Wrench> force;
  Output<CouplingParameters> parameters;
};

struct Predictor final : Idle {
  struct Params {
    bool adaptive = true;
    int order = 0;
  };
  Predictor(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Predictor>("test.predictor", "Looks ahead.")
        .input("force", &Predictor::force, {.trigger = Trigger::yes})
        .input("coefficients", &Predictor::coefficients, {.required = false})
        .ignored_when([](const Params& p) { return p.adaptive ? std::string() : "the coefficients are fixed"; })
        .output("forecast", &Predictor::forecast, "")
        .boolean("adaptive", &Params::adaptive, true, "refits")
        .integer("order", &Params::order, {.doc = "order", .default_value = 3, .min = 1, .max = 9})
        .info();
  }
  Input<Wrench> force;
  Input<ArCoefficients> coefficients;
  Output<Forecast> forecast;
};

struct Refit final : Idle {
  struct Params {};
  Refit(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Refit>("test.refit", "Fits.")
        .input("force", &Refit::force, {.trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 512}})
        .output("coefficients", &Refit::coefficients, "")
        .info();
  }
  Input<Wrench> force;
  Output<ArCoefficients> coefficients;
};

struct Hold final : Idle {
  struct Params {};
  Hold(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Hold>("test.hold", "Holds.")
        .input("forecast", &Hold::forecast, {.trigger = Trigger::yes})
        .output("segment", &Hold::segment, "")
        .info();
  }
  Input<Forecast> forecast;
  Output<ForceSegment> segment;
};

// Its margin is that of the collision node.
struct Surface final : Idle {
  struct Params {
    double margin = 0;
  };
  Surface(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Surface>("test.surface", "Finds contacts itself.")
        .input("device", &Surface::device, {.trigger = Trigger::yes})
        .output("contacts", &Surface::contacts, "")
        .real("margin", &Params::margin,
              {.doc = "reach", .unit = "m", .default_value = 2e-3, .min = 0, .max = 0.1, .as_in = Role::collision})
        .info();
  }
  Input<DeviceState> device;
  Output<ContactSet> contacts;
};

struct Torque final : Idle {
  struct Params {};
  Torque(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Torque>("test.twist", "Works on torque.")
        .needs_torque()
        .input("force", &Torque::force, {.trigger = Trigger::yes})
        .output("out", &Torque::out, "")
        .info();
  }
  Input<Wrench> force;
  Output<Wrench> out;
};

struct Gate final : Idle {
  struct Params {};
  Gate(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Gate>("test.gate", "Passes on.")
        .realtime_safe()
        .input("in", &Gate::in, {.trigger = Trigger::yes})
        .input("side", &Gate::side, {.required = false})
        .output("out", &Gate::out, "")
        .info();
  }
  Input<Wrench> in;
  Input<Wrench> side;
  Output<Wrench> out;
};

// Its place is the realtime lane.
struct Motor final : Idle {
  struct Params {
    double rate = 0;
  };
  Motor(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Motor>("test.motor", "Drives a device.")
        .actuator()
        .sink()
        .input("force", &Motor::force, {.required = false})
        .output("state", &Motor::state, "")
        .haptic_rate(&Params::rate, {.doc = "steps"})
        .info();
  }
  Input<Wrench> force;
  Output<DeviceState> state;
};

// Its place is the thread `physics`; what comes in waits for it.
struct Solver final : Idle {
  struct Params {};
  Solver(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Solver>("test.solver", "Is heavy.")
        .on_thread("physics")
        .input("device", &Solver::device, {.trigger = Trigger::yes, .queue = {QueuePolicy::block, 2}})
        .output("force", &Solver::force, "")
        .info();
  }
  Input<DeviceState> device;
  Output<Wrench> force;
};

struct Listener final : Idle {
  struct Params {};
  Listener(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Listener>("test.listener", "Never steps by itself.")
        .input("in", &Listener::in, {})
        .output("out", &Listener::out, "")
        .info();
  }
  Input<Wrench> in;
  Output<Wrench> out;
};

struct Values final : Idle {
  enum class Color { red, green };
  struct Params {
    double rate = 0;
    bool flag = false;
    std::int64_t count = 0;
    double length = 0;
    Duration pause;
    std::string label;
    Color color = Color::red;
    fs::path data;
    std::vector<double> gains, free;
    Table rows;
    Mapping names;
  };
  Values(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Values>("test.values", "A parameter of every kind.")
        .sink()
        .rate("rate", &Params::rate, {.doc = "steps", .default_value = 10})
        .boolean("flag", &Params::flag, false, "a flag")
        .integer("count", &Params::count, {.doc = "a count", .default_value = 3, .min = -5, .max = 1000})
        .real("length", &Params::length,
              {.doc = "a length", .unit = "m", .default_value = 1, .min = 0, .above_min = true})
        .real("pause", &Params::pause, {.doc = "a time", .unit = "s", .default_value = 0.5})
        .text("label", &Params::label, "none", "a text")
        .choice("color", &Params::color, {{"red", Color::red}, {"green", Color::green}}, std::optional(Color::red),
                "a color")
        .file("data", &Params::data, false, "a file")
        .reals("gains", &Params::gains, 3, std::vector<double>{1, 2, 3}, {.doc = "three forces", .unit = "N"})
        .reals("free", &Params::free, 0, std::vector<double>{}, {.doc = "numbers", .min = -1, .max = 1})
        .table("rows", &Params::rows, {{"t", "s", {}}, {"z", "m", 0.25}}, false, "rows")
        .mapping("names", &Params::names, false, "names")
        .info();
  }
};

struct Judge final : Idle {
  struct Params {};
  Judge(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Judge>("test.judge", "Judges.")
        .sink()
        .input("commanded", &Judge::commanded, {.trigger = Trigger::yes})
        .input("force", &Judge::force, {.required = false, .reference = true})
        .info();
  }
  Input<Wrench> commanded;
  Input<Wrench> force;
};

}  // namespace

Registry test_registry() {
  Registry registry({});
  registry.add<Device>();
  registry.add<Collision>();
  registry.add<Dynamics>();
  registry.add<Coupling>();
  registry.add<Predictor>();
  registry.add<Refit>();
  registry.add<Hold>();
  registry.add<Surface>();
  registry.add<Torque>();
  registry.add<Gate>();
  registry.add<Motor>();
  registry.add<Solver>();
  registry.add<Listener>();
  registry.add<Values>();
  registry.add<Judge>();
  return registry;
}

fs::path Folder::write(const std::string& name, const std::string& text) const {
  const fs::path file = path() / name;
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

Overrides settings(const std::vector<std::string>& texts) {
  Overrides overrides;
  for (const std::string& text : texts) overrides.push_back(set_patch(text));
  return overrides;
}

GraphSpec load_text(const Folder& folder, const std::string& text, const Overrides& overrides) {
  // The declarations must outlive the specs that point to them.
  static Registry registry = test_registry();
  return load_graph(folder.write("graph.yaml", text), registry, overrides);
}

std::string errors_of(const Folder& folder, const std::string& text, const Overrides& overrides) {
  try {
    load_text(folder, text, overrides);
  } catch (const GraphError& e) {
    return e.what();
  }
  return {};
}

std::string pipeline(const std::string& scene) {
  return "duration: 1 s\nscene:\n" + scene + R"(nodes:
  device: {type: test.device}
  collision: {type: test.collision, cost: {per_contact: 0.5 ms, base: 6 ms, jitter: 10 %}}
  dynamics: {type: test.dynamics, cost: {constant: 100 us}}
  coupling: {type: test.coupling, stiffness: 0.8 N/mm}
  predictor: {type: test.predictor}
  refit: {type: test.refit}
  hold: {type: test.hold}
  judge: {type: test.judge}
edges:
  - device.state -> collision.device
  - device.state -> dynamics.device
  - collision.contacts -> dynamics.contacts
  - dynamics.state -> collision.state
  - coupling.parameters -> dynamics.coupling
  - dynamics.state -> coupling.state
  - coupling.force -> predictor.force
  - coupling.force -> refit.force
  - refit.coefficients -> predictor.coefficients
  - predictor.forecast -> hold.forecast
  - hold.segment -> device.segment
  - device.commanded -> judge.commanded
  - coupling.force -> judge.force
record:
  - coupling.force
)";
}

}  // namespace tactor::testing
