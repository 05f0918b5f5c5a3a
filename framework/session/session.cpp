#include "framework/session/session.hpp"

#include <algorithm>
#include <deque>
#include <exception>
#include <list>
#include <set>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/read_budget.hpp"
#include "framework/engine/setting_effects.hpp"
#include "framework/graph/queue_bounds.hpp"
#include "framework/node/set_request.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

/// Requests of nodes that may wait.
constexpr std::size_t request_bytes = std::size_t{64} << 10U;

/// Messages with arrays that may wait.
constexpr std::uint32_t most_with_arrays = 4;

/// Messages that wait for one who takes them on the session's thread.
struct Subscription {
  /// `bytes`: of what may wait.
  Subscription(const MessageType& type, std::size_t bytes, Session::Take reader)
      : tap(type, {QueuePolicy::drop_newest, capacity_for(type, bytes)}), take(std::move(reader)) {}

  static std::uint32_t capacity_for(const MessageType& type, std::size_t bytes) {
    // What waits keeps its arrays from their pool, which is bounded.
    if (!type.arrays.empty()) return most_with_arrays;
    return static_cast<std::uint32_t>(std::clamp<std::size_t>(bytes / (type.size + sizeof(Stamp)), 16, 65536));
  }
  /// What `take` throws passes through, and then it gets nothing more.
  void drain() {
    tap.take_all([this](const Stamp& stamp, const void* value) {
      try {
        take(stamp, value);
      } catch (...) {
        take = [](const Stamp&, const void*) {};
        throw;
      }
    });
  }

  Tap tap;
  Session::Take take;
  std::uint64_t number = 0;  ///< as Session::Subscribed; 0: it stays
};

struct TunableParameter {
  std::size_t node = 0;
  std::size_t param = 0;
};

/// A value of a tunable parameter.
struct NewValue {
  TunableParameter at;
  ParamValue value;
  std::string text;  ///< the value as a graph file has it
};

/// A node's parameters with a value that is new.
struct Change {
  std::size_t node = 0;
  std::vector<ParamValue> params;
  std::shared_ptr<const void> typed;  ///< the same as the struct of the node's class
  SetEvent event;
};

TunableParameter find_tunable(const Plan& plan, std::string_view name) {
  const std::string asked(name);
  std::vector<std::string> tunable;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const std::vector<ParamInfo>& params = plan.nodes[n].info->params;
    for (std::size_t p = 0; p < params.size(); ++p) {
      const std::string full = plan.nodes[n].name + "." + params[p].name;
      if (params[p].tunable) tunable.push_back(full);
      if (full != asked) continue;
      if (params[p].tunable) return {n, p};
      throw InputError(asked + " cannot be set during the run: " + plan.nodes[n].info->type +
                       " reads it when it is made; begin a run anew with another value");
    }
  }
  throw InputError("the run has no parameter " + asked + did_you_mean(asked, tunable));
}

/// The plan whose nodes write no files of their own. What that changes is noted.
Plan without_tables(Plan plan, std::vector<std::string>& notes) {
  for (NodeSpec& node : plan.nodes) {
    for (std::size_t p = 0; p < node.params.size(); ++p) {
      const auto& value = node.info->params[p].in_replay;
      if (!value || *value == node.params[p]) continue;
      node.params[p] = *value;
      notes.push_back("node " + node.name + ": " + node.info->params[p].name +
                      " is left empty, because this run writes no tables");
    }
  }
  return plan;
}

}  // namespace

PlannedOutput find_output(const Plan& plan, std::string_view name) {
  const std::size_t dot = name.find('.');
  const std::string node(name.substr(0, dot));
  std::vector<std::string> names;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const std::vector<OutputInfo>& outputs = plan.nodes[n].info->outputs;
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      names.push_back(plan.nodes[n].name + "." + outputs[o].name);
      if (names.back() == name) return {n, o};
    }
  }
  for (const LeftOut& left_out : plan.left_out) {
    if (left_out.kind == LeftOut::Kind::node && left_out.node == node) {
      throw InputError("the run has no output " + std::string(name) + ": its node was left out, because " +
                       left_out.why + "; record it in the graph");
    }
  }
  throw InputError("the run has no output " + std::string(name) + did_you_mean(std::string(name), names));
}

class Session::Run {
  /// A request of node `by`.
  struct Asked {
    std::size_t by = 0;
    SetRequest request;
  };
  /// A setting of `node`, for which node `by` has asked.
  struct Made {
    std::size_t by = 0;
    std::size_t node = 0;
  };

 public:
  Run(Plan p, const SessionOptions& options)
      : plan(options.keeps_tables ? std::move(p) : without_tables(std::move(p), notes)),
        engine(make_engine(plan, options.engine, options.replay)) {
    for (const NodeSpec& node : plan.nodes) params.push_back(node.params);
    read_settings();
  }

  /// The value as the parameter takes it. Throws InputError where there is none.
  [[nodiscard]] NewValue parsed(std::string_view parameter, std::string_view value) const {
    return parsed_at(find_tunable(plan, parameter), std::string(value));
  }
  [[nodiscard]] NewValue parsed_at(const TunableParameter& at, std::string text) const {
    const NodeSpec& node = plan.nodes[at.node];
    const std::string where = "set " + node.name + "." + node.info->params[at.param].name + "=" + text;
    return {at, parse_parameter(node, at.param, text, where), std::move(text)};
  }

  /// The change to that value. Throws InputError where the node refuses it together with its other parameters.
  [[nodiscard]] Change changed(const NewValue& to) const {
    const NodeSpec& node = plan.nodes[to.at.node];
    const NodeInfo& info = *node.info;
    const std::string text = info.params[to.at.param].name + "=" + to.text;
    const std::string where = "set " + node.name + "." + text + ": ";
    Change change{to.at.node, params[to.at.node], nullptr, {.node = static_cast<std::int32_t>(to.at.node)}};
    change.params[to.at.param] = to.value;
    const Tuning& tuning = info.tuning.value();
    change.typed = tuning.typed(change.params);
    const Node& made = engine->nodes()[to.at.node];
    const std::string why = tuning.refuses ? tuning.refuses(made, change.typed.get()) : "";
    if (!why.empty()) throw InputError(where + why);
    if (text.size() > SetEvent::most_text) {
      throw InputError("set " + node.name + "." + info.params[to.at.param].name + ": the value is too long");
    }
    change.event.length = static_cast<std::int32_t>(text.size());
    std::copy(text.begin(), text.end(), change.event.text.begin());
    return change;
  }

  void set(const NewValue& to) {
    Change change = changed(to);
    NodeSpec spec = plan.nodes[change.node];
    spec.params = change.params;
    check_node(plan.graph, spec);
    engine->set(change.node, std::move(change.typed), change.event);
    params[change.node] = std::move(change.params);
  }

  void attach(Tap& tap, const PlannedOutput& at) const {
    engine->with_dispatcher([&](Dispatcher& dispatcher) { dispatcher.add_tap(at.node, at.output, tap); });
  }

  /// A subscription of what `attach(dispatcher, tap)` adds a tap to.
  template <class Attach>
  Subscription& subscribe(const MessageType& type, Take take, std::size_t bytes, const Attach& attach) {
    // Where a full tap is read by its writer a small one is enough.
    const bool one_thread = engine->steps_on_caller();
    Subscription& made =
        subscriptions.emplace_back(type, one_thread ? std::min(bytes, std::size_t{1} << 16U) : bytes, std::move(take));
    if (one_thread) made.tap.when_full([&made] { made.drain(); });
    engine->with_dispatcher([&](Dispatcher& dispatcher) { attach(dispatcher, made.tap); });
    return made;
  }

  /// Hands what waits to all that take it, and then throws the first thing that one of them threw.
  void read() {
    std::exception_ptr first;
    for (Subscription& subscription : subscriptions) {
      try {
        subscription.drain();
      } catch (...) {
        if (!first) first = std::current_exception();
      }
    }
    if (first) std::rethrow_exception(first);
  }

  /// Reads what nodes ask of the run, in their order.
  void read_requests() {
    for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
      if (!plan.nodes[n].info->sets) continue;
      const auto take = [this, n](const Stamp& /*stamp*/, const void* value) {
        asked.push_back({n, *static_cast<const SetRequest*>(value)});
      };
      const std::vector<OutputInfo>& outputs = plan.nodes[n].info->outputs;
      for (std::size_t o = 0; o < outputs.size(); ++o) {
        if (!same_type(*outputs[o].type, message_type<SetRequest>())) continue;
        attach(requests.emplace_back(*outputs[o].type, request_bytes, take).tap, {n, o});
      }
    }
  }

  /// Does what nodes have asked for, up to the first that has to wait until the one before is in force.
  bool serve() {
    for (Subscription& request : requests) {
      request.drain();
      if (request.tap.dropped() > 0) throw RunError("a node sends more set requests at a time than a run can handle");
    }
    while (engine->is_running()) {
      if (last_made) {
        if (!engine->is_set(last_made->node)) return false;
        engine->set(last_made->by, nullptr,
                    {.node = static_cast<std::int32_t>(last_made->by), .length = 0, .text = {}});
        last_made.reset();
      }
      if (asked.empty()) return true;
      const Asked next = asked.front();
      asked.pop_front();
      make(next);
    }
    return true;
  }

  /// The values of all settings that nodes may ask for. Throws YamlError with the place of the first that cannot be
  /// made.
  void read_settings() {
    settings.resize(plan.nodes.size());
    for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
      const NodeSpec& node = plan.nodes[n];
      if (!node.info->sets) continue;
      for (const Setting& setting : node.info->sets(node.params)) {
        try {
          settings[n].push_back(parsed(setting.parameter, setting.value));
          static_cast<void>(changed(settings[n].back()));
        } catch (const InputError& error) {
          const std::string path = "nodes." + node.name + "." + setting.path;
          throw YamlError({{plan.graph.place_of(path), path + ": " + error.what()}});
        }
      }
    }
  }

  /// Does what a node has asked for. Throws RunError where that is refused.
  void make(const Asked& next) {
    if (next.request.kind == RequestKind::end_run) return engine->stop("");
    try {
      const auto index = static_cast<std::size_t>(next.request.setting);
      if (index >= settings[next.by].size()) throw InputError("there is no setting of index " + std::to_string(index));
      NewValue value = settings[next.by][index];
      if (next.request.kind == RequestKind::set_number) {
        const std::string& unit = plan.nodes[value.at.node].info->params[value.at.param].unit;
        value = parsed_at(value.at, number_text(next.request.number) + (unit == "1" ? "" : " " + unit));
      }
      set(value);
      last_made = {next.by, value.at.node};
    } catch (const std::exception& error) {
      const std::string about(about_of(next.request));
      throw RunError((about.empty() ? "" : about + ": ") + error.what());
    }
  }

  std::vector<std::string> notes;  // of what is left empty
  const Plan plan;
  const std::unique_ptr<Engine> engine;
  std::vector<std::vector<ParamValue>> params;  // by node, as they were set last
  std::vector<std::vector<NewValue>> settings;  // by node, those that it may ask for
  std::list<Subscription> subscriptions;
  std::list<Subscription> requests;  // of nodes
  std::deque<Asked> asked;           // not done yet
  std::optional<Made> last_made;     // of the newest request, not in force yet
  const Attendance attendance{[this] { read(); }, [this] { return serve(); }};
  std::uint64_t messages_begun = 0;    // by on_message
  std::uint64_t dropped_by_ended = 0;  // by subscriptions that have ended
  std::set<std::size_t> claimed;       // nodes whose inputs somebody has
  bool started = false, finished = false;
};

Session::Session(Plan plan, const SessionOptions& options) : run_(std::make_unique<Run>(std::move(plan), options)) {
  if (options.replay == nullptr) {
    for (const std::string& note : run_->notes) nodes().note(note);
    check_effects(run_->plan);
  }
  run_->read_requests();
}

Session::~Session() {
  if (run_->started && !run_->finished) run_->engine->finish({});
  // A step that never came back still runs in it: nothing may end its life.
  if (is_abandoned()) static_cast<void>(run_.release());
}

const Plan& Session::plan() const {
  return run_->plan;
}

PlanNodes& Session::nodes() {
  return run_->engine->nodes();
}

std::unique_ptr<Session::OutputTap> Session::tap(std::string_view output, Queue queue) {
  const PlannedOutput at = find_output(plan(), output);
  check_queue(queue, type_of(plan(), at), "the tap of " + std::string(output));
  auto made = std::make_unique<OutputTap>(*this, type_of(plan(), at), queue);
  run_->attach(made->tap_, at);
  return made;
}

std::unique_ptr<Session::OutputTap> Session::tap_stop() {
  auto made = std::make_unique<OutputTap>(*this, message_type<StopEvent>(), Queue{QueuePolicy::drop_newest, 1});
  run_->engine->with_dispatcher([&](Dispatcher& dispatcher) { dispatcher.add_stop_tap(made->tap_); });
  return made;
}

void Session::end_tap(const Tap& tap) {
  run_->engine->with_dispatcher([&](Dispatcher& dispatcher) { dispatcher.remove_tap(tap); });
}

Session::Subscribed Session::on_message(std::string_view output, Take take, std::size_t bytes) {
  const PlannedOutput at = find_output(plan(), output);
  Subscription& made =
      run_->subscribe(type_of(plan(), at), std::move(take), bytes,
                      [&at](Dispatcher& dispatcher, Tap& tap) { dispatcher.add_tap(at.node, at.output, tap); });
  made.number = ++run_->messages_begun;
  return Subscribed{made.number};
}

void Session::end_messages(Subscribed subscribed) {
  std::list<Subscription>& all = run_->subscriptions;
  const auto ended = std::find_if(all.begin(), all.end(), [&](const Subscription& one) {
    return one.number == static_cast<std::uint64_t>(subscribed);
  });
  TACTOR_DEMAND(ended != all.end());
  end_tap(ended->tap);
  run_->dropped_by_ended += ended->tap.dropped();
  all.erase(ended);
}

void Session::on_step(Take take, std::size_t bytes) {
  run_->subscribe(message_type<StepEvent>(), std::move(take), bytes, std::mem_fn(&Dispatcher::add_step_tap));
}

void Session::on_tick(Take take, std::size_t bytes) {
  run_->subscribe(message_type<TickEvent>(), std::move(take), bytes, std::mem_fn(&Dispatcher::add_tick_tap));
}

void Session::on_stop(Take take) {
  run_->subscribe(message_type<StopEvent>(), std::move(take), 1, std::mem_fn(&Dispatcher::add_stop_tap));
}

void Session::on_set(Take take) {
  run_->subscribe(message_type<SetEvent>(), std::move(take), request_bytes, std::mem_fn(&Dispatcher::add_set_tap));
}

Session::Feed Session::feed(std::string_view name) {
  const Plan& plan = run_->plan;
  const auto feed_of = [&](const PlannedOutput& at) { return Feed(*run_, at, type_of(plan, at)); };
  std::vector<std::string> names;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const NodeSpec& node = plan.nodes[n];
    if (!node.info->fed) continue;
    const std::vector<OutputInfo>& outputs = node.info->outputs;
    if (outputs.size() == 1) names.push_back(node.name);
    if (outputs.size() == 1 && node.name == name) return feed_of({n, 0});
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      names.push_back(node.name + "." + outputs[o].name);
      if (names.back() == name) return feed_of({n, o});
    }
  }
  for (const PlannedEdge& edge : plan.edges) {
    if (!plan.nodes[edge.from].info->fed) continue;
    names.push_back(edge.spec.to_node + "." + edge.spec.to_port);
    if (names.back() == name) return feed_of({edge.from, edge.output});
  }
  throw InputError("the run has no feed " + std::string(name) + did_you_mean(std::string(name), names) +
                   "; a node of type source.feed makes one");
}

bool Session::Feed::send(const void* value, std::optional<Time> valid) {
  TACTOR_DEMAND(run_->started);
  const FedValue fed{at_.output, value};
  return run_->engine->feed(at_.node, valid, {&fed, 1});
}

bool Session::send(std::size_t node, std::optional<Time> valid, std::span<const FedValue> values) {
  TACTOR_DEMAND(run_->started && plan().nodes[node].info->fed);
  return run_->engine->feed(node, valid, values);
}

void Session::read_inputs(std::size_t node, const std::function<void(Node&)>& read) {
  TACTOR_DEMAND(plan().nodes[node].info->fed);
  run_->engine->with_dispatcher([&](Dispatcher& /*dispatcher*/) { read(nodes()[node]); });
}

bool Session::claim_inputs(std::size_t node) {
  TACTOR_DEMAND(plan().nodes[node].info->fed);
  return run_->claimed.insert(node).second;
}

void Session::set(std::string_view parameter, std::string_view value) {
  TACTOR_DEMAND(run_->started);
  run_->set(run_->parsed(parameter, value));
}

std::uint64_t Session::dropped() const {
  std::uint64_t sum = run_->dropped_by_ended + run_->engine->dropped();
  for (const Subscription& subscription : run_->subscriptions) sum += subscription.tap.dropped();
  return sum;
}

void Session::stop_when(std::function<bool()> asked) {
  run_->engine->stop_when(std::move(asked));
}

bool Session::is_started() const {
  return run_->started;
}

void Session::start() {
  TACTOR_DEMAND(!run_->started);
  heed_new_requests_alone();
  run_->engine->start();
  run_->started = true;
}

void Session::advance(Duration duration) {
  TACTOR_DEMAND(run_->started && !run_->finished);
  run_->engine->advance(duration, run_->attendance);
}

bool Session::is_running() {
  return run_->started && !run_->finished && run_->engine->is_running();
}

Time Session::now() {
  return run_->engine->now();
}

EngineStatus Session::status() {
  return run_->engine->status();
}

void Session::stop() {
  run_->engine->stop("");
}

void Session::finish() {
  TACTOR_DEMAND(run_->started && !run_->finished);
  run_->finished = true;
  run_->engine->finish(run_->attendance);
}

void Session::run(Duration slice, const std::function<void()>& meanwhile) {
  if (!run_->started) start();
  try {
    while (is_running()) {
      advance(slice);
      meanwhile();
    }
  } catch (...) {
    // Before anything else is done, devices ramp down.
    try {
      finish();
    } catch (const std::exception&) {
      // The first failure is the one that is told.
    }
    throw;
  }
  finish();
}

std::optional<std::string> Session::failure() const {
  return run_->engine->failure();
}

bool Session::is_abandoned() const {
  return run_->engine->is_abandoned();
}

NodeStatistics Session::node_statistics(std::size_t node) const {
  return run_->engine->node_statistics(node);
}

std::vector<Duration> Session::step_times(std::size_t node) const {
  if (plan().nodes[node].scheduling.lane == Lane::realtime) return {};
  return run_->engine->step_times(node);
}

EdgeStatistics Session::edge_statistics(std::size_t edge) const {
  return run_->engine->edge_statistics(edge);
}

Duration Session::cpu_time() const {
  return run_->engine->cpu_time();
}

FlightFile* Session::flight() {
  return run_->engine->flight();
}

}  // namespace tactor
