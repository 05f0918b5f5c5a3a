// Nodes that take time, fail or hang, for tests of the live engine.
#pragma once

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/core/random.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/declare.hpp"

namespace tactor::sample {

/// Works for a random time that it draws itself, then sends the sum of all it has seen, weighted by its step count.
class Worker final : public Node {
 public:
  struct Params {
    double longest = 0;  ///< s
  };
  Worker(const Params& params, const NodeContext& context) : params_(params), state_(context.seed) {}
  static NodeInfo declare() {
    return Declare<Worker>("sample.worker", "Works.")
        .input("in", &Worker::in, {.doc = "what makes it step", .trigger = Trigger::yes})
        .input("back", &Worker::back, {.doc = "an answer", .required = false})
        .output("out", &Worker::out, "what it made")
        .real("longest", &Params::longest, {.doc = "longest step", .unit = "s", .default_value = 0})
        .info();
  }
  void step(StepContext& context) override {
    state_ = derive_seed(state_, "next");
    const double share = static_cast<double>(state_ % 1000) / 1000;
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(share * params_.longest);
    Stamped<Wrench> m;
    ++steps_;
    while (in.pop(m)) sum_ += steps_ * m.value.force.x + static_cast<double>(m.stamp.sequence);
    if (back.connected() && back.latest() != nullptr) sum_ += 0.5 * back.latest()->value.force.x;
    while (std::chrono::steady_clock::now() < until) {
    }
    out.send(context.now(), {{sum_ * 1e-3, steps_, 0}, {}});
  }
  Input<Wrench> in, back;
  Output<Wrench> out;

 private:
  Params params_;
  std::uint64_t state_;
  double steps_ = 0;
  double sum_ = 0;
};

/// Does something bad at its step `when`.
class Culprit final : public Node {
 public:
  enum class Deed { throws, hangs };
  struct Params {
    Deed deed = Deed::throws;
    std::int32_t when = 0;
    double hang = 0;  ///< s
  };
  Culprit(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare() {
    return Declare<Culprit>("sample.culprit", "Does something bad.")
        .input("in", &Culprit::in, {.doc = "what makes it step", .trigger = Trigger::yes})
        .output("out", &Culprit::out, "what it saw")
        .choice("deed", &Params::deed, {{"throws", Deed::throws}, {"hangs", Deed::hangs}}, std::optional(Deed::throws),
                "what it does")
        .integer("when", &Params::when, {.doc = "at which step", .default_value = 10})
        .real("hang", &Params::hang, {.doc = "how long", .unit = "s", .default_value = 1})
        .info();
  }
  void step(StepContext& context) override {
    if (++steps_ == params_.when) {
      if (params_.deed == Deed::throws) throw std::runtime_error("it broke");
      std::this_thread::sleep_for(std::chrono::duration<double>(params_.hang));
    }
    out.send(context.now(), in.latest()->value);
  }
  Input<Wrench> in;
  Output<Wrench> out;

 private:
  Params params_;
  std::int32_t steps_ = 0;
};

/// A device in the real-time lane: notes what it sees, shows a count, and comes to rest 50 ms after it is told to stop.
class Actor final : public Node {
 public:
  struct Params {
    double rate = 1000;
  };
  Actor(const Params&, const NodeContext&) { seen.reserve(100'000); }
  static NodeInfo declare() {
    return Declare<Actor>("sample.actor", "Acts.")
        .actuator()
        .input("in", &Actor::in, {.doc = "what to do", .required = false})
        .output("out", &Actor::out, "a count")
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 1000})
        .info();
  }
  struct Seen {
    Time now;
    Phase phase;
    bool any;
    Time produced;
    double value;
  };
  void step(StepContext& context) override {
    const auto* m = in.latest();
    seen.push_back(
        {context.now(), context.phase(), m != nullptr, m ? m->stamp.produced : Time{}, m ? m->value.force.x : 0.0});
    out.send(context.now(), {{count_++, 0, 0}, {}});
    if (context.phase() == Phase::stopping && ++stopping_ < 50) context.not_at_rest();
  }
  Input<Wrench> in;
  Output<Wrench> out;
  std::vector<Seen> seen;

 private:
  double count_ = 0;
  int stopping_ = 0;
};

/// A light node at a rate: notes what it sees, and sends gain times the one input plus the other. At its step `when` it
/// hangs, or throws where `hang` is 0.
class Filter final : public Node {
 public:
  struct Params {
    double rate = 1000;
    double gain = 1;
    std::int32_t when = 0;
    double hang = 0;  ///< s
  };
  Filter(const Params& params, const NodeContext&) : params_(params) { seen.reserve(100'000); }
  static NodeInfo declare() {
    return Declare<Filter>("sample.filter", "Filters.")
        .input("in", &Filter::in, {.doc = "what comes", .required = false})
        .input("other", &Filter::other, {.doc = "what is added", .required = false})
        .output("out", &Filter::out, "what goes")
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 1000})
        .real("gain", &Params::gain, {.doc = "gain", .default_value = 1})
        .integer("when", &Params::when, {.doc = "at which step", .default_value = 0})
        .real("hang", &Params::hang, {.doc = "how long", .unit = "s", .default_value = 0})
        .tunable({"gain"})
        .info();
  }
  struct Seen {
    Time now;
    Stamp stamp;  ///< of the one input; sequence -1: it has none yet
    double value;
    double other;
  };
  void step(StepContext& context) override {
    const auto* m = in.latest();
    const auto* more = other.latest();
    const double value = m != nullptr ? m->value.force.x : 0, added = more != nullptr ? more->value.force.x : 0;
    seen.push_back({context.now(), m != nullptr ? m->stamp : Stamp{{}, {}, ~std::uint64_t{0}}, value, added});
    if (static_cast<std::int32_t>(seen.size()) == params_.when) {
      if (params_.hang == 0) throw std::runtime_error("it broke");
      std::this_thread::sleep_for(std::chrono::duration<double>(params_.hang));
    }
    out.send(context.now(), {{params_.gain * value + added, 0, 0}, {}});
  }
  void tune(const Params& params) { params_ = params; }
  Input<Wrench> in, other;
  Output<Wrench> out;
  std::vector<Seen> seen;

 private:
  Params params_;
};

/// The parameters of a Filter.
inline std::vector<ParamValue> filter(double rate = 1000, double gain = 1, std::int64_t when = 0, double hang = 0) {
  return {rate, gain, when, hang};
}

/// Of the real-time lane, without privileges.
inline const Scheduling in_loop{Lane::realtime, "", SchedulingPolicy::other, {}, {}};

/// A plan put together by hand.
struct PlanBuilder {
  Plan plan;

  explicit PlanBuilder(double duration_s) {
    plan.graph.name = "sample";
    plan.graph.clock = Clock::real;
    plan.graph.duration = Duration::from_seconds(duration_s);
    plan.graph.live.pool = {};  // no privileges are asked for
  }
  std::size_t node(const std::string& name, const NodeInfo& info, std::vector<ParamValue> params,
                   Scheduling scheduling = {}) {
    plan.nodes.push_back({name, &info, std::move(params), {}, std::move(scheduling), {}});
    return plan.nodes.size() - 1;
  }
  std::size_t edge(std::size_t from, std::size_t to, std::size_t input, Queue queue, bool triggers,
                   Duration delay = {}) {
    PlannedEdge edge;
    edge.spec.from_node = plan.nodes[from].name;
    edge.spec.from_port = "out";
    edge.spec.to_node = plan.nodes[to].name;
    edge.spec.to_port = plan.nodes[to].info->inputs[input].name;
    edge.spec.queue = queue;
    edge.spec.delay = delay;
    edge.from = from;
    edge.to = to;
    edge.input = input;
    edge.triggers = triggers;
    plan.edges.push_back(edge);
    return plan.edges.size() - 1;
  }
  void record(std::size_t node) {
    plan.streams.push_back({plan.nodes[node].name + ".out", node, 0});
    plan.graph.record.push_back(plan.nodes[node].name + ".out");
  }
};

}  // namespace tactor::sample
