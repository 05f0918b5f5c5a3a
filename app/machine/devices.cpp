#include "app/machine/devices.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "app/confirmation.hpp"
#include "app/output.hpp"
#include "app/run/headline.hpp"
#include "app/run/run.hpp"
#include "framework/core/segment.hpp"
#include "framework/core/shown_text.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

namespace {

/// What a device has shown in a trial.
struct Shown {
  DeviceState newest;
  bool any = false;
  Vec3 least, most;

  void add(const DeviceState& state) {
    const Vec3& p = state.X_WD.p;
    for (int i = 0; i < 3; ++i) {
      least[i] = any ? std::min(least[i], p[i]) : p[i];
      most[i] = any ? std::max(most[i], p[i]) : p[i];
    }
    newest = state;
    any = true;
  }
};

/// Watches a device and gives it forces: a half sine along x, y and z in turn, to and fro, once the device is engaged.
class TrialForce final : public Node {
 public:
  struct Params {
    double force = 0;    // N
    double seconds = 1;  // s, of each half sine
  };
  TrialForce(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare() {
    return Declare<TrialForce>("trial.force", "Small forces on a device that is tried.")
        .sink()
        .input("state", &TrialForce::state, {.doc = "of the device", .trigger = Trigger::yes})
        .input("safety", &TrialForce::safety, {.doc = "of its gate"})
        .output("segment", &TrialForce::segment, "the force")
        .real("force", &Params::force, {.doc = "the largest", .unit = "N", .min = 0})
        .real("seconds", &Params::seconds, {.doc = "of each half sine", .unit = "s", .min = 0, .above_min = true})
        .info();
  }

  void step(StepContext& context) override {
    if (safety.latest() != nullptr && safety.latest()->value.engagement == Engagement::engaged && !begun_) {
      begun_ = true;
      begin_ = context.now();
    }
    segment.send(state.latest()->stamp.valid, constant_segment(context.now(), {force_at(context.now()), {}}));
  }

  Input<DeviceState> state;
  Input<SafetyState> safety;
  Output<ForceSegment> segment;

 private:
  [[nodiscard]] Vec3 force_at(Time now) const {
    if (!begun_) return {};
    const double turn = (now - begin_).seconds() / params_.seconds;
    const int which = static_cast<int>(turn);
    if (which >= 6) return {};
    Vec3 force;
    force[which / 2] = (which % 2 == 0 ? 1 : -1) * params_.force * std::sin(std::numbers::pi * (turn - which));
    return force;
  }

  Params params_;
  bool begun_ = false;
  Time begin_;
};

/// In a trial a newton is one at the hand, and the gate's brake, which pushes with up to `force_max` whatever a node
/// wants, gets no more than the trial.
void limit_to_trial(NodeSpec& device, double force) {
  const auto change = [&device](const std::string& name, auto changed) {
    const auto param = device.info->param(name);
    if (!param) return;
    auto& value = std::get<double>(device.params[*param]);
    value = changed(value);
  };
  change("force_scale", [](double) { return 1.0; });
  change("force_max", [force](double most) { return std::min(most, force); });
  change("torque_max", [](double) { return 0.0; });
}

/// The device alone with the node above. No force is larger than `force` (N).
GraphSpec trial_graph(const GraphSpec& graph, const NodeSpec& device, double force, double seconds, double duration,
                      Registry& registry) {
  GraphSpec trial = graph;
  trial.clock = Clock::real;
  trial.duration = Duration::from_seconds(duration);
  trial.nodes = {device};
  limit_to_trial(trial.nodes.front(), force);
  trial.edges.clear();
  trial.record.clear();
  NodeSpec source;
  source.name = "trial";
  source.info = registry.find("trial.force");
  source.params = {force, seconds};
  source.scheduling = default_scheduling(*source.info);
  source.place = device.place;
  trial.nodes.push_back(source);
  const auto edge = [&](const std::string& from, const std::string& out, const std::string& to, const std::string& in) {
    EdgeSpec e;
    e.from_node = from;
    e.from_port = out;
    e.to_node = to;
    e.to_port = in;
    e.place = device.place;
    trial.edges.push_back(e);
  };
  edge(device.name, "state", "trial", "state");
  edge(device.name, "safety", "trial", "safety");
  edge("trial", "segment", device.name, "segment");
  return trial;
}

/// What is told before a trial.
struct Beforehand {
  std::vector<std::string> notes;
  bool lacks_dead_man = false;
};

/// Runs it and shows where the device is, ten times a second on a terminal, else once a second.
RunResult run_trial(const GraphSpec& graph, const std::atomic<int>& interrupted, Shown& shown, Beforehand& told_of) {
  const bool terminal = isatty(STDOUT_FILENO) == 1;
  double told = -1;
  RunOptions options;
  options.note = [&told_of](const std::string& note) { told_of.notes.push_back(note); };
  // The force has a question of its own.
  options.without_dead_man = [&told_of](const std::string&) { return told_of.lacks_dead_man = true; };
  options.before_start = [&](Session& session) {
    session.on_message(graph.nodes.front().name + ".state", [&shown](const Stamp&, const void* value) {
      DeviceState state;
      std::memcpy(&state, value, sizeof state);
      shown.add(state);
    });
  };
  options.live_progress = [&](const LiveLook& look) {
    if (!shown.any || look.status.now.seconds() - told < (terminal ? 0.1 : 1.0)) return true;
    told = look.status.now.seconds();
    const Vec3& p = shown.newest.X_WD.p;
    const Vec3& v = shown.newest.V_WD.v;
    const std::string row =
        fmt::format("  {:6.2f} s  position {:8.2f} {:8.2f} {:8.2f} mm  speed {:7.3f} m/s  buttons {:b}", told,
                    1e3 * p.x, 1e3 * p.y, 1e3 * p.z, norm(v), shown.newest.buttons);
    draw_on_terminal(STDOUT_FILENO, terminal ? "\r" + row + "   " : row + "\n");
    return true;
  };
  options.stop_asked = [&interrupted] { return interrupted != 0; };
  RunResult result = execute(make_plan(graph), options);
  if (terminal) fmt::print("\n");
  return result;
}

int tell_result(const RunResult& result, const Shown& shown, const std::string& what) {
  for (const std::string& remark : result.remarks) fmt::print("  {}\n", remark);
  if (result.failure) {
    tell_note(*result.failure);
    return 1;
  }
  if (!shown.any && result.interrupted) {
    fmt::print("  ended before the device showed a position\n");
    return 0;
  }
  if (!shown.any) {
    tell("tactor: the device has shown no position\n");
    return 1;
  }
  const Vec3 way = shown.most - shown.least;
  fmt::print("  {}: moved x {:.2f} y {:.2f} z {:.2f} mm; {:.0f} cycles, age of a sample p99 {:.2f} ms\n", what,
             1e3 * way.x, 1e3 * way.y, 1e3 * way.z, result.metric("device.link.cycles"),
             1e-3 * result.metric("device.link.age_us.p99"));
  return 0;
}

}  // namespace

std::string device_list(const Registry& registry) {
  std::string out;
  for (const NodeInfo* info : registry.types()) {
    if (!info->hardware || !info->hardware->discover) continue;
    std::vector<std::string> notes;
    try {
      for (const std::string& line : info->hardware->discover(notes))
        out += fmt::format("  {:<18} {}\n", info->type, line);
    } catch (const RunError& error) {
      notes.push_back(error.what());
    }
    for (const std::string& note : notes) tell_note(note);
  }
  return out.empty() ? "no device is attached that Tactor recognises\n" : out;
}

const NodeSpec& hardware_node(const GraphSpec& graph, const std::string& name) {
  const NodeSpec* found = nullptr;
  std::string names;
  for (const NodeSpec& node : graph.nodes) {
    if (!node.info->hardware) continue;
    names += (names.empty() ? "" : ", ") + node.name;
    if (name.empty() && found != nullptr) {
      throw InputError(graph.file.string() + ": expected --node with one of the devices of the graph (" + names +
                       ", ...), found none");
    }
    if (name.empty() || node.name == name) found = &node;
  }
  if (found != nullptr) return *found;
  throw InputError(graph.file.string() + ": expected a node that drives hardware" +
                   (name.empty() ? "" : " and has the name " + name) + ", found " +
                   (names.empty() ? "none; device types are listed by `tactor nodes`" : names));
}

int try_device(const GraphSpec& graph, const NodeSpec& device, const DeviceTrial& trial, Registry& registry,
               const std::atomic<int>& interrupted) {
  registry.add<TrialForce>();
  fmt::print("  {} ({}): its position, without a force\n", device.name, device.info->type);
  const double watch = std::max(trial.seconds, 0.5);
  Beforehand beforehand, told_already;
  Shown at_rest, moved;
  const RunResult watched =
      run_trial(trial_graph(graph, device, 0, 1, watch, registry), interrupted, at_rest, beforehand);
  if (const int code = tell_result(watched, at_rest, "moved"); code != 0 || watched.interrupted) return code;
  for (const std::string& note : beforehand.notes) fmt::print("  Note: {}\n", note);
  if (beforehand.lacks_dead_man) fmt::print("  No button stops the force when you let go.\n");
  const std::string question = fmt::format("  Apply up to {:g} N along x, y and z of the scene and back, for {:g} s?",
                                           trial.force, 6 * trial.seconds);
  if (!confirmed(question, trial.yes, interrupted)) {
    fmt::print("  no force was given\n");
    return 0;
  }
  const GraphSpec forces = trial_graph(graph, device, trial.force, trial.seconds, 6 * trial.seconds + 2, registry);
  const RunResult pushed = run_trial(forces, interrupted, moved, told_already);
  const int code = tell_result(pushed, moved, fmt::format("moved by up to {:g} N", trial.force));
  if (code != 0 || pushed.interrupted || !pushed.force_was_withheld()) return code;
  tell_note(no_force_text(pushed));
  return 1;
}

void calibrate_device(const NodeSpec& device, bool yes, const std::atomic<int>& interrupted) {
  const std::optional<HardwareAccess>& hardware = device.info->hardware;
  if (!hardware || !hardware->calibrate) {
    throw InputError("node " + device.name + ": " + device.info->type + " needs no calibration");
  }
  const Ask ask = [yes, &interrupted](const std::string& text) { return confirmed(text, yes, interrupted); };
  fmt::print("{}\n", hardware->calibrate(device.params, ask));
}

}  // namespace tactor
