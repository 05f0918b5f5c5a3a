#include "framework/session/session.hpp"

#include <algorithm>
#include <deque>
#include <list>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/read_budget.hpp"
#include "framework/engine/live/live_engine.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/engine/setting_effects.hpp"
#include "framework/engine/virtual_clock.hpp"
#include "framework/graph/queue_bounds.hpp"
#include "framework/node/set_request.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor {

namespace {

/// How often the session's thread looks after a live run, and how long a slice of a paced one is.
constexpr Duration live_period{20'000'000};
constexpr Duration paced_period{2'000'000};
/// And how often while a request waits for the one before.
constexpr Duration waiting_period{1'000'000};

/// Under the virtual clock requests of nodes are done at multiples of it, so that they are the same however the time is
/// cut into advances.
constexpr Duration request_period{1'000'000};
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
    if (left_out.what == "node " + node) {
      throw InputError("the run has no output " + std::string(name) + ": its node was left out, because " +
                       left_out.why + "; record it in the graph");
    }
  }
  throw InputError("the run has no output " + std::string(name) + did_you_mean(std::string(name), names));
}

class Session::Run {
 public:
  Run(Plan p, const SessionOptions& o)
      : plan(o.keeps_tables ? std::move(p) : without_tables(std::move(p), notes)), options(o) {
    for (const NodeSpec& node : plan.nodes) params.push_back(node.params);
    if (options.replay != nullptr) {
      replay = std::make_unique<ReplayClock>(plan, *options.replay);
      clock = &replay->clock();
      replay->on_set([this](const RunLog::Set& set) { tell_set(set.stamp, set.event); });
    } else if (plan.graph.clock == Clock::real) {
      live = load_live_library().make(plan);
    } else {
      own_clock =
          std::make_unique<VirtualClock>(plan, options.measure_cpu, std::vector<bool>{}, nullptr, options.meter);
      if (options.keeps_step_times) own_clock->keep_step_times();
      clock = own_clock.get();
    }
  }

  /// Under the virtual clock.
  [[nodiscard]] Time end() const { return replay ? replay->end() : Time{} + plan.graph.duration; }

  /// Under the virtual clock a full queue is read, so that a small one is enough.
  [[nodiscard]] std::size_t waiting_bytes(std::size_t bytes) const {
    return live ? bytes : std::min(bytes, std::size_t{1} << 16U);
  }

  void add(Subscription& subscription, const std::function<void(Tap&)>& attach) {
    // Live, writer and reader are two threads.
    if (clock) subscription.tap.when_full([&subscription] { subscription.drain(); });
    attach(subscription.tap);
  }

  void drain() {
    for (Subscription& subscription : subscriptions) subscription.drain();
  }

  void attach(Subscription& subscription, const PlannedOutput& at) {
    live ? live->add_tap(at.node, at.output, subscription.tap)
         : clock->dispatcher().add_tap(at.node, at.output, subscription.tap);
  }

  /// Takes what nodes ask of the run, in their order, and does it by `make`, which returns the node that it has set; a
  /// replay has it from its log.
  void take_requests(std::function<std::optional<std::size_t>(const SetRequest&)> make) {
    if (replay) return;
    make_request = std::move(make);
    const auto take = [this](const Stamp& /*stamp*/, const void* value) {
      asked.push_back(*static_cast<const SetRequest*>(value));
      make_requests();
    };
    for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
      if (!plan.nodes[n].info->sets) continue;
      const std::vector<OutputInfo>& outputs = plan.nodes[n].info->outputs;
      for (std::size_t o = 0; o < outputs.size(); ++o) {
        if (!same_type(*outputs[o].type, message_type<SetRequest>())) continue;
        std::list<Subscription>& to = live ? subscriptions : requests;
        attach(to.emplace_back(*outputs[o].type, request_bytes, take), {n, o});
      }
    }
  }

  /// Does what nodes have asked for, up to the first that has to wait until the one before holds.
  void make_requests() {
    while (!asked.empty() && !(live && set_last && !live->is_tuned(*set_last))) {
      const SetRequest request = asked.front();
      asked.pop_front();
      set_last = make_request(request);
    }
  }

  /// Live: what a subscriber throws is the run's failure.
  void drain_live() {
    const auto attempt = [this](const auto& work) {
      try {
        work();
      } catch (const std::exception& error) {
        live->stop(error.what());
      }
    };
    for (Subscription& subscription : subscriptions) attempt([&] { subscription.drain(); });
    attempt([this] { make_requests(); });
  }

  void tell_set(const Stamp& stamp, const SetEvent& event) const {
    for (const Session::Take& take : set_takers) take(stamp, &event);
  }

  void advance_live(Duration duration) {
    const Instant until = MonotonicClock::now() + duration;
    while (live->is_running() && MonotonicClock::now() < until) {
      drain_live();
      const Duration pause = asked.empty() ? live_period : waiting_period;
      MonotonicClock::sleep_until(std::min(MonotonicClock::now() + pause, until));
    }
    drain_live();
  }

  void advance_virtual(Duration duration) {
    const Time until = std::min(clock->now() + duration, end());
    if (options.pace > 0) {
      const Instant begun = MonotonicClock::now();
      const Time from = clock->now();
      while (clock->now() < until && !stopped) {
        step_with_requests(std::min(clock->now() + paced_period, until));
        drain();
        const double wall = (clock->now() - from).seconds() / options.pace;
        MonotonicClock::sleep_until(begun + Duration::from_seconds(wall));
      }
    } else {
      step_with_requests(until);
    }
    drain();
  }

  /// Does what nodes ask for as time passes.
  void step_with_requests(Time until) {
    if (requests.empty()) return step_to(until);
    while (clock->now() < until && !stopped) {
      const Time next{(clock->now().ns / request_period.ns + 1) * request_period.ns};
      step_to(std::min(until, next));
      if (clock->now() < next) continue;
      for (Subscription& request : requests) {
        request.drain();
        if (request.tap.dropped() > 0)
          throw RunError("a node sends more set requests in a millisecond than a run can handle");
      }
    }
  }

  /// Where a step throws, what was sent before it still gets to those who take it.
  void step_to(Time t) {
    try {
      replay ? replay->advance_to(t) : clock->advance_to(t);
    } catch (const std::exception&) {
      for (Subscription& subscription : subscriptions) {
        try {
          subscription.drain();
        } catch (const std::exception&) {
          // The first failure is the one that is told.
        }
      }
      throw;
    }
  }

  std::vector<std::string> notes;  // of what is left empty
  const Plan plan;
  const SessionOptions options;
  std::vector<std::vector<ParamValue>> params;  // by node, as they were set last
  std::vector<Session::Take> set_takers;
  std::uint64_t sets = 0;
  std::unique_ptr<VirtualClock> own_clock;
  std::unique_ptr<ReplayClock> replay;
  VirtualClock* clock = nullptr;  // one of these, or null
  std::unique_ptr<LiveEngine> live;
  std::list<Subscription> subscriptions;
  std::list<Subscription> requests;  // of nodes, under the virtual clock
  std::function<std::optional<std::size_t>(const SetRequest&)> make_request;
  std::deque<SetRequest> asked;                   // by nodes, not done yet
  std::optional<std::size_t> set_last;            // the node that a request has set last
  std::vector<std::vector<Duration>> step_times;  // live, by node, where they are kept
  std::uint64_t messages_begun = 0;               // by on_message
  std::uint64_t dropped_by_ended = 0;             // by subscriptions that have ended
  bool started = false, stopped = false, finished = false;
};

Session::Session(Plan plan, const SessionOptions& options) : run_(std::make_unique<Run>(std::move(plan), options)) {
  for (const NodeSpec& node : run_->plan.nodes) {
    if (!node.info->sets) continue;
    for (const Setting& setting : node.info->sets(node.params)) {
      try {
        static_cast<void>(parsed(setting.text));
      } catch (const InputError& error) {
        const std::string path = "nodes." + node.name + "." + setting.path;
        throw YamlError({{run_->plan.graph.place_of(path), path + ": " + error.what()}});
      }
    }
  }
  if (options.replay == nullptr) {
    for (const std::string& note : run_->notes) nodes().note(note);
    check_effects(run_->plan);
  }
  if (options.keeps_step_times && run_->live) {
    run_->step_times.resize(run_->plan.nodes.size());
    on_step([run = run_.get()](const Stamp& stamp, const void* value) {
      const auto node = static_cast<std::size_t>(static_cast<const StepEvent*>(value)->node);
      run->step_times[node].push_back(stamp.produced - stamp.valid);
    });
  }
  run_->take_requests([this](const SetRequest& request) -> std::optional<std::size_t> {
    if (!is_running()) return std::nullopt;
    if (request.kind == RequestKind::end_run) {
      stop();
      return std::nullopt;
    }
    const std::string_view text = text_of(request);
    const std::size_t equals = text.find('=');
    try {
      set(text.substr(0, equals), text.substr(equals + 1));
      return find_tunable(run_->plan, text.substr(0, equals)).node;
    } catch (const std::exception& error) {
      const std::string about(about_of(request));
      throw RunError((about.empty() ? "" : about + ": ") + error.what());
    }
  });
}

Session::~Session() {
  if (run_->live && run_->started && !run_->finished) finish();
  // A step that never came back still runs in it: nothing may end its life.
  if (is_abandoned()) static_cast<void>(run_.release());
}

const Plan& Session::plan() const {
  return run_->plan;
}

PlanNodes& Session::nodes() {
  return run_->live ? run_->live->nodes() : run_->clock->nodes();
}

bool Session::is_live() const {
  return run_->live != nullptr;
}

std::unique_ptr<Session::OutputTap> Session::tap(std::string_view output, Queue queue) {
  const PlannedOutput at = find_output(plan(), output);
  check_queue(queue, type_of(plan(), at), "the tap of " + std::string(output));
  auto made = std::make_unique<OutputTap>(*this, type_of(plan(), at), queue);
  if (run_->live) {
    run_->live->add_tap(at.node, at.output, made->tap_);
  } else {
    run_->clock->dispatcher().add_tap(at.node, at.output, made->tap_);
  }
  return made;
}

std::unique_ptr<Session::OutputTap> Session::tap_stop() {
  auto made = std::make_unique<OutputTap>(*this, message_type<StopEvent>(), Queue{QueuePolicy::drop_newest, 1});
  if (run_->live) {
    run_->live->add_stop_tap(made->tap_);
  } else {
    run_->clock->dispatcher().add_stop_tap(made->tap_);
  }
  return made;
}

void Session::end_tap(const Tap& tap) {
  if (run_->live) {
    run_->live->remove_tap(tap);
  } else {
    run_->clock->dispatcher().remove_tap(tap);
  }
}

Session::Subscribed Session::on_message(std::string_view output, Take take, std::size_t bytes) {
  const PlannedOutput at = find_output(plan(), output);
  Subscription& made =
      run_->subscriptions.emplace_back(type_of(plan(), at), run_->waiting_bytes(bytes), std::move(take));
  run_->add(made, [&](Tap& /*tap*/) { run_->attach(made, at); });
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
  Subscription& made =
      run_->subscriptions.emplace_back(message_type<StepEvent>(), run_->waiting_bytes(bytes), std::move(take));
  run_->add(made, [&](Tap& tap) {
    run_->live ? run_->live->add_step_tap(tap) : run_->clock->dispatcher().add_step_tap(tap);
  });
}

void Session::on_tick(Take take, std::size_t bytes) {
  Subscription& made =
      run_->subscriptions.emplace_back(message_type<TickEvent>(), run_->waiting_bytes(bytes), std::move(take));
  run_->add(made, [&](Tap& tap) {
    run_->live ? run_->live->add_tick_tap(tap) : run_->clock->dispatcher().add_tick_tap(tap);
  });
}

void Session::on_stop(Take take) {
  Subscription& made = run_->subscriptions.emplace_back(message_type<StopEvent>(), 1, std::move(take));
  run_->add(made, [&](Tap& tap) {
    run_->live ? run_->live->add_stop_tap(tap) : run_->clock->dispatcher().add_stop_tap(tap);
  });
}

void Session::on_set(Take take) {
  run_->set_takers.push_back(std::move(take));
}

Session::Feed Session::feed(std::string_view name) {
  const Plan& plan = run_->plan;
  const auto fed = [&plan](std::size_t n) { return plan.nodes[n].info->fed; };
  const auto feed_of = [&](std::size_t n) { return Feed(*run_, n, *plan.nodes[n].info->outputs.front().type); };
  std::vector<std::string> names;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    if (!fed(n)) continue;
    names.push_back(plan.nodes[n].name);
    if (plan.nodes[n].name == name) return feed_of(n);
  }
  for (const PlannedEdge& edge : plan.edges) {
    if (!fed(edge.from)) continue;
    names.push_back(edge.spec.to_node + "." + edge.spec.to_port);
    if (names.back() == name) return feed_of(edge.from);
  }
  throw InputError("the run has no feed " + std::string(name) + did_you_mean(std::string(name), names) +
                   "; a node of type source.feed makes one");
}

bool Session::Feed::send(const void* value, std::optional<Time> valid) {
  TACTOR_DEMAND(run_->started);
  if (run_->live) return run_->live->feed(node_, valid, value);
  Dispatcher& dispatcher = run_->clock->dispatcher();
  if (dispatcher.is_blocked(node_)) return false;
  dispatcher.publish(node_, 0, valid.value_or(run_->clock->now()), value);
  return true;
}

Session::Change Session::parsed(std::string_view text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  const std::string_view parameter = text.substr(0, equals);
  const std::string_view value = text.substr(std::min(equals + 1, text.size()));
  const TunableParameter at = find_tunable(plan(), parameter);
  const NodeInfo& info = *plan().nodes[at.node].info;
  NodeSpec changed = plan().nodes[at.node];
  changed.params = run_->params[at.node];
  changed.params[at.param] = parse_parameter(changed, at.param, std::string(value),
                                             "set " + std::string(parameter) + "=" + std::string(value));
  std::shared_ptr<const void> typed = info.typed(changed.params);
  if (const std::string why = info.refuses ? info.refuses(nodes()[at.node], typed.get()) : ""; !why.empty()) {
    throw InputError("set " + std::string(parameter) + "=" + std::string(value) + ": " + why);
  }
  std::string event = info.params[at.param].name + "=" + std::string(value);
  if (event.size() > SetEvent::most_text) throw InputError("set " + std::string(parameter) + ": the value is too long");
  return {at.node, std::move(changed.params), std::move(typed), std::move(event)};
}

Session::Change Session::checked(std::string_view text) {
  Change change = parsed(text);
  NodeSpec changed = plan().nodes[change.node];
  changed.params = change.params;
  check_node(plan().graph, changed);
  return change;
}

void Session::set(std::string_view parameter, std::string_view value) {
  TACTOR_DEMAND(run_->started);
  Change change = checked(std::string(parameter) + "=" + std::string(value));
  SetEvent event;
  event.node = static_cast<std::int32_t>(change.node);
  event.length = static_cast<std::int32_t>(change.event.size());
  std::copy(change.event.begin(), change.event.end(), event.text.begin());
  Time from;
  if (run_->live) {
    from = run_->live->tune(change.node, change.typed);
  } else {
    plan().nodes[change.node].info->tune(nodes()[change.node], change.typed.get());
    from = run_->clock->now();
  }
  run_->params[change.node] = std::move(change.params);
  const Stamp stamp{from, from, run_->sets++};
  run_->tell_set(stamp, event);
}

std::uint64_t Session::dropped() const {
  std::uint64_t sum = run_->dropped_by_ended;
  for (const Subscription& subscription : run_->subscriptions) sum += subscription.tap.dropped();
  return sum;
}

void Session::stop_when(std::function<bool()> asked) {
  if (run_->live) run_->live->stop_when(std::move(asked));
}

void Session::start() {
  TACTOR_DEMAND(!run_->started);
  heed_new_requests_alone();
  if (run_->live) {
    run_->live->start();
  } else {
    run_->clock->start();
  }
  run_->started = true;
}

void Session::advance(Duration duration) {
  TACTOR_DEMAND(run_->started && !run_->finished);
  if (run_->live) {
    run_->advance_live(duration);
  } else if (!run_->stopped) {
    run_->advance_virtual(duration);
  }
}

bool Session::is_running() {
  if (!run_->started || run_->finished || run_->stopped) return false;
  if (run_->live) return run_->live->is_running();
  return run_->clock->now() < run_->end();
}

Time Session::now() {
  return run_->live ? status().now : run_->clock->now();
}

LiveStatus Session::status() {
  TACTOR_DEMAND(run_->live != nullptr);
  return run_->live->look();
}

void Session::stop() {
  if (run_->live) {
    run_->live->stop("");
  } else {
    run_->stopped = true;
  }
}

void Session::finish() {
  TACTOR_DEMAND(run_->started && !run_->finished);
  run_->finished = true;
  if (run_->live) {
    run_->live->finish([this] { run_->drain_live(); });
  } else {
    run_->drain();
  }
}

std::optional<std::string> Session::failure() const {
  return run_->live ? run_->live->failure() : std::nullopt;
}

bool Session::is_abandoned() const {
  return run_->live && run_->live->is_abandoned();
}

NodeStatistics Session::node_statistics(std::size_t node) const {
  return run_->live ? run_->live->node_statistics(node) : run_->clock->node_statistics(node);
}

std::vector<Duration> Session::step_times(std::size_t node) const {
  if (plan().nodes[node].scheduling.lane == Lane::realtime || !run_->options.keeps_step_times) return {};
  if (run_->live) return run_->step_times[node];
  return run_->own_clock ? run_->own_clock->step_times(node) : std::vector<Duration>{};
}

EdgeStatistics Session::edge_statistics(std::size_t edge) const {
  return run_->live ? run_->live->status().edges[edge].metrics : run_->clock->edge_statistics(edge);
}

const LiveStatus& Session::last_status() const {
  TACTOR_DEMAND(run_->live != nullptr);
  return run_->live->status();
}

}  // namespace tactor
