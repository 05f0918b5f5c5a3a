#include "framework/session/physics_loop.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "framework/core/between_samples.hpp"
#include "framework/core/check.hpp"
#include "framework/core/handle_between.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

constexpr const char* external_physics = "physics.external";
constexpr std::size_t most_samples = 4096;
/// So many samples of the handle, none of which can be used, end the run.
constexpr std::uint64_t most_unusable = 100;
/// What `next` lets pass before it looks whether the run has ended.
constexpr Duration longest_wait{20'000'000};
/// How often it looks for a sample of the handle, live.
constexpr Duration sample_wait{1'000'000};
/// Under the virtual clock, what happens at an instant has happened when so much more has passed.
constexpr Duration shortest{1};

/// True where a program may step the node: it is physics, and is filled from outside of the run.
bool is_external(const NodeInfo& info) {
  const auto takes = [&](const char* name, const MessageType& type) {
    const InputInfo* input = info.input(name);
    return input != nullptr && same_type(*input->type, type);
  };
  const auto gives = [&](const char* name, const MessageType& type) {
    const OutputInfo* output = info.output(name);
    return output != nullptr && same_type(*output->type, type);
  };
  return info.fed && info.role == Role::dynamics && info.param("rate") &&
         takes("device", message_type<DeviceState>()) && takes("coupling", message_type<CouplingParameters>()) &&
         gives("state", message_type<PhysicsState>()) && gives("bodies", message_type<BodyStates>()) &&
         gives("contacts", message_type<ContactSet>()) && gives("force", message_type<Wrench>()) &&
         gives("engine", message_type<EngineState>());
}

std::size_t find_external(const Plan& plan, std::string_view name) {
  std::vector<std::string> names;
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    if (!is_external(*plan.nodes[n].info)) continue;
    names.push_back(plan.nodes[n].name);
    found.push_back(n);
    if (names.back() == name) return n;
  }
  const std::string of_type = std::string(" of type ") + external_physics;
  if (!name.empty()) {
    throw InputError("the run has no node " + std::string(name) + of_type + did_you_mean(std::string(name), names));
  }
  if (found.empty()) {
    throw InputError("the run has no node" + of_type + "; a graph whose physics is a program's own has one");
  }
  if (found.size() > 1) {
    std::string list;
    for (const std::string& one : names) list += (list.empty() ? "" : ", ") + one;
    throw InputError("the run has several nodes" + of_type + ": name one of " + list);
  }
  return found.front();
}

std::vector<Motion> motions_of(const Scene& scene) {
  std::vector<Motion> motions;
  for (const std::size_t index : scene.moving()) motions.push_back(scene.bodies[index].motion);
  return motions;
}

double rate_of(const NodeSpec& node) {
  return std::get<double>(node.params[node.info->param("rate").value()]);
}

/// Refuses edges at which a program would have to wait.
void check_policies(const Plan& plan, std::size_t node) {
  for (const PlannedEdge& edge : plan.edges) {
    if ((edge.from != node && edge.to != node) || edge.spec.queue.policy != QueuePolicy::block) continue;
    throw InputError("edge " + edge.spec.name() + ": expected another policy than block, for which the program of " +
                     plan.nodes[node].name + " would have to wait; found block");
  }
}

bool has_edge(const Plan& plan, std::size_t node, std::string_view input, std::string_view output) {
  return std::any_of(plan.edges.begin(), plan.edges.end(), [&](const PlannedEdge& edge) {
    return (edge.to == node && edge.spec.to_port == input) || (edge.from == node && edge.spec.from_port == output);
  });
}

template <class T>
Stamped<T> copied(const MessageView& view) {
  Stamped<T> message{*view.stamp, {}};
  std::memcpy(static_cast<void*>(&message.value), view.value, sizeof(T));
  return message;
}

}  // namespace

DeviceState PhysicsStep::handle_at(Time t) const {
  if (t <= begin) return from;
  if (t >= end) return handle;
  DeviceState then = handle_between(from, handle, share_between(begin, end, t), true);
  then.buttons = from.buttons;
  return then;
}

PhysicsLoop::PhysicsLoop(Session& session, std::string_view node)
    : session_(session),
      node_(find_external(session.plan(), node)),
      rate_(rate_of(session.plan().nodes[node_])),
      is_virtual_(session.plan().graph.clock == Clock::virtual_),
      moving_(motions_of(session.plan().graph.scene)),
      has_coupling_(has_edge(session.plan(), node_, "coupling", {})),
      reads_force_(has_edge(session.plan(), node_, {}, "force")),
      reads_contacts_(has_edge(session.plan(), node_, {}, "contacts")),
      reads_states_(has_edge(session.plan(), node_, {}, "engine")) {
  check_policies(session.plan(), node_);
  if (!session.claim_inputs(node_)) {
    throw InputError("node " + this->node().name + " has a loop of physics already; a session has one for each node");
  }
  samples_.reserve(2 * most_samples);
}

std::string PhysicsLoop::node_of(const Plan& plan, std::string_view node) {
  return plan.nodes[find_external(plan, node)].name;
}

void PhysicsLoop::rollout(std::size_t numbers, CopyFunction step) {
  const std::string name = "node " + node().name + ": ";
  if (session_.is_started()) throw InputError(name + "expected the light copy before the session starts");
  if (copy_states_) throw InputError(name + "the program has given a light copy already");
  if (numbers == 0 || !step) throw InputError(name + "expected a light copy with a step and 1 number or more");
  if (reads_states_ && !has_coupling_) {
    throw InputError(name + "a light copy moves its tool by the graph's coupling; expected an edge into " +
                     node().name + ".coupling, found none");
  }
  copy_states_ = std::make_unique<ArrayPool<double>>(most_engine_states, numbers);
  const LightCopy copy{numbers, std::move(step)};
  const Plan& plan = session_.plan();
  std::vector<std::size_t> senders{node_};
  for (std::size_t i = 0; i < senders.size(); ++i) {
    for (const PlannedEdge& edge : plan.edges) {
      const OutputInfo& output = plan.nodes[edge.from].info->outputs[edge.output];
      if (edge.from != senders[i] || !same_type(*output.type, message_type<EngineState>())) continue;
      auto* const reader = dynamic_cast<StepsCopy*>(&session_.nodes()[edge.to]);
      if (reader == nullptr || std::find(senders.begin(), senders.end(), edge.to) != senders.end()) continue;
      reader->take_copy(copy);
      senders.push_back(edge.to);
    }
  }
}

/// Refuses a graph that goes on by a light copy, where the program has given none.
void PhysicsLoop::check_copy() const {
  if (!reads_states_ || copy_states_) return;
  throw InputError("node " + node().name + ": the graph reads " + node().name +
                   ".engine, the state of a light copy of the program's simulator, and the program has given none; a "
                   "program in C++ gives it by PhysicsLoop::rollout before the first step, and one in Python takes "
                   "another method, such as --over local");
}

/// Tells which feed nobody filled, where a run has come to its end without a sample of the handle.
void PhysicsLoop::check_hand() const {
  const Plan& plan = session_.plan();
  if (gate_.refusals().came() > 0 || session_.now() < Time{} + plan.graph.duration) return;
  for (const PlannedEdge& edge : plan.edges) {
    const NodeSpec& feed = plan.nodes[edge.from];
    if (!feed.info->fed || !plan.nodes[edge.to].info->actuator) continue;
    const std::string input = edge.spec.to_node + "." + edge.spec.to_port;
    throw RunError("node " + node().name +
                   ": the run has ended without a step, because no sample of the handle came: " + "nobody filled " +
                   input + ", which node " + feed.name +
                   " feeds. Send the first target before the first step, by Session::feed(\"" + input +
                   "\").send(...), in Python session.feed(...)");
  }
}

std::optional<PhysicsStep> PhysicsLoop::next() {
  while (is_running()) {
    if (auto step = next_within(longest_wait)) return step;
  }
  return std::nullopt;
}

std::optional<PhysicsStep> PhysicsLoop::next_within(Duration longest) {
  check_copy();
  if (!session_.is_started()) session_.start();
  if (!due_) due_ = period_after(session_.now());
  while (session_.is_running()) {
    if (const Time now = session_.now(); now < *due_) {
      if (longest <= Duration{}) return std::nullopt;
      const Duration part = std::min(*due_ - now, longest);
      session_.advance(part);
      longest = longest - part;
      continue;
    }
    if (is_virtual_) {
      for (const PhysicsMessages& messages : pending_) send(messages);
      pending_.clear();
      // So that the sample of this very instant is there.
      session_.advance(shortest);
    }
    read_inputs();
    PhysicsStep step;
    const bool begins = begin_step(step);
    due_ = begins || is_virtual_ ? period_after(session_.now()) : session_.now() + sample_wait;
    if (begins) return step;
  }
  check_hand();
  return std::nullopt;
}

void PhysicsLoop::read_inputs() {
  forget_samples();
  session_.read_inputs(node_, [this](Node& physics) {
    const NodeInfo& info = *node().info;
    InputBase& device = info.input("device")->access(physics);
    while (device.connected()) {
      const MessageView view = device.queue().take();
      if (!view) break;
      auto sample = copied<DeviceState>(view);
      if (gate_.admit(sample)) samples_.push_back(sample);
    }
    InputBase& coupling = info.input("coupling")->access(physics);
    if (!coupling.connected()) return;
    while (const MessageView view = coupling.queue().take()) coupling_ = copied<CouplingParameters>(view).value;
  });
  const Refusals& refused = gate_.refusals();
  if (refused.refused() < most_unusable || refused.refused() < refused.came()) return;
  throw RunError("node " + node().name + ": none of the " + std::to_string(refused.came()) +
                 " samples of the handle that came can be used: they are not finite, or their rotations are zero");
}

/// False where no sample of the handle has come since the last step, or the coupling has not come yet.
bool PhysicsLoop::begin_step(PhysicsStep& step) {
  if (samples_.empty() || (has_coupling_ && !coupling_)) return false;
  const Stamped<DeviceState>& newest = samples_.back();
  Stamped<DeviceState> from = samples_.front();
  if (last_) {
    from = *last_;
  } else {
    // The first step is one period long, where so much is known.
    const Time begin = newest.stamp.valid - Duration::from_rate(rate_);
    for (const auto& sample : samples_) {
      if (sample.stamp.valid <= begin) from = sample;
    }
  }
  if (from.stamp.valid >= newest.stamp.valid) return false;
  step = {
      from.stamp.valid, newest.stamp.valid, from.value, newest.value, coupling_.value_or(CouplingParameters{}), this};
  last_ = newest;
  return true;
}

/// Drops the samples that no result can ask for: those before the one before the last result, and the oldest where
/// there are too many.
void PhysicsLoop::forget_samples() {
  const auto later = std::find_if(samples_.begin(), samples_.end(), [this](const Stamped<DeviceState>& sample) {
    return !last_result_ || sample.stamp.valid > *last_result_;
  });
  auto first = later == samples_.begin() ? later : later - 1;
  if (samples_.end() - first > static_cast<std::ptrdiff_t>(most_samples)) {
    first = samples_.end() - static_cast<std::ptrdiff_t>(most_samples);
  }
  samples_.erase(samples_.begin(), first);
}

/// The handle at `t`, between the samples around; the first before, the last after them.
DeviceState PhysicsLoop::handle_at(Time t) const {
  const auto later = std::find_if(samples_.begin(), samples_.end(),
                                  [t](const Stamped<DeviceState>& sample) { return sample.stamp.valid > t; });
  if (later == samples_.begin()) return later == samples_.end() ? DeviceState{} : later->value;
  const Stamped<DeviceState>& a = *(later - 1);
  if (later == samples_.end() || a.stamp.valid == t) return a.value;
  return handle_between(a.value, later->value, share_between(a.stamp.valid, later->stamp.valid, t), true);
}

/// When the first period after `t` begins; from its number, so that no rounding adds up.
Time PhysicsLoop::period_after(Time t) const {
  Time begin;
  for (auto k = static_cast<std::int64_t>(std::floor(t.seconds() * rate_));; ++k) {
    begin = {std::llround(static_cast<double>(k) * 1e9 / rate_)};
    if (begin > t) return begin;
  }
}

/// Reads the samples up to that time of a result.
Time PhysicsLoop::checked_time(Time valid) {
  const Time now = session_.now();
  if (valid <= now && valid > samples_.back().stamp.valid) read_inputs();
  const Time kept = samples_.front().stamp.valid, first = std::max(kept, last_result_.value_or(kept));
  if (valid >= first && valid <= now) return valid;
  throw ResultError("time", "expected " + number_text(first.seconds()) + " s, that of the " +
                                (last_result_ == first ? "last result" : "first sample of the handle") + ", to " +
                                number_text(now.seconds()) + " s, which is now, found " + number_text(valid.seconds()) +
                                " s");
}

void PhysicsLoop::result(const PhysicsStep& step, const PhysicsResult& result) {
  if (step.loop != this || !last_) throw ResultError("step", "expected a step of this loop, found one of another");
  const Time valid = checked_time(result.time.value_or(step.end));
  const DeviceState handle = handle_at(valid);
  PhysicsMessages messages = physics_messages(result, valid, handle, moving_);
  messages.engine = copy_state(step, result, messages, handle);
  if (reads_force_ && !messages.force) {
    throw ResultError("felt", "expected a wrench, because the graph reads " + node().name +
                                  ".force; found none. A graph that takes the force from its coupling does without it");
  }
  if (reads_contacts_ && !messages.contacts) {
    throw ResultError("contacts", "expected a list, because the graph reads " + node().name +
                                      ".contacts; found none. An empty list says that nothing is near");
  }
  last_result_ = valid;
  if (is_virtual_) {
    pending_.push_back(std::move(messages));
  } else {
    send(messages);
  }
}

/// The message of the result's state of the light copy; none where nobody reads it.
std::optional<EngineState> PhysicsLoop::copy_state(const PhysicsStep& step, const PhysicsResult& result,
                                                   const PhysicsMessages& messages, const DeviceState& handle) {
  const std::span<const double> state = result.copy_state;
  if (!copy_states_ && !state.empty()) {
    throw ResultError("copy_state", "expected none, because the program has given no light copy (rollout), found " +
                                        std::to_string(state.size()) + " numbers");
  }
  const std::size_t expected = copy_states_ ? copy_states_->capacity() : 0;
  if (state.size() != expected && (reads_states_ || !state.empty())) {
    throw ResultError("copy_state", "expected " + std::to_string(expected) +
                                        " numbers, those of the light copy that the program gave, found " +
                                        std::to_string(state.size()));
  }
  const auto bad = std::find_if(state.begin(), state.end(), [](double x) { return !std::isfinite(x); });
  if (bad != state.end()) throw ResultError("copy_state", "expected finite numbers, found " + number_text(*bad));
  if (!reads_states_) return std::nullopt;
  const auto numbers = copy_states_->copy(state);
  if (!numbers) {
    ++dropped_states_;
    return std::nullopt;
  }
  // A result with a state has a tool.
  const PhysicsState& then = messages.state.value();
  const bool turns = moving_.front() == Motion::rigid;
  return EngineState{.identity = expected,
                     .time = messages.valid,
                     .device = handle,
                     .X_WT = then.X_WT,
                     .V_WT = then.V_WT,
                     .p_WT_result = then.X_WT.p,
                     .wrench_result = wrench_on_device(step.coupling, handle, then.X_WT, then.V_WT, turns),
                     .coupling = step.coupling,
                     .position = *numbers,
                     .velocity = {},
                     .activation = {},
                     .acceleration = {}};
}

void PhysicsLoop::send(const PhysicsMessages& messages) {
  std::array<FedValue, 5> values;
  std::size_t count = 0;
  const auto add = [&](const char* output, const auto& message) {
    if (!message) return;
    const NodeInfo& info = *node().info;
    values[count++] = {static_cast<std::size_t>(info.output(output) - info.outputs.data()), &*message};
  };
  add("state", messages.state);
  add("bodies", messages.bodies);
  add("contacts", messages.contacts);
  add("force", messages.force);
  add("engine", messages.engine);
  // No edge from here has the policy `block`.
  static_cast<void>(session_.send(node_, messages.valid, std::span(values).first(count)));
}

}  // namespace tactor
