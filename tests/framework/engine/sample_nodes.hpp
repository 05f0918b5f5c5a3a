// Three small nodes and hand-made plans for tests of engines.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/declare.hpp"

namespace tactor::sample {

/// Sends its step count as force.x at a rate; in a reference run at ten times the rate.
class Counter final : public Node {
 public:
  struct Params {
    double rate = 1000;
  };
  Counter(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Counter>("sample.counter", "Counts.")
        .output("out", &Counter::out, "the count")
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 1000, .in_reference = 10000})
        .info();
  }
  void step(StepContext& context) override { out.send(context.now(), {{static_cast<double>(count++), 0, 0}, {}}); }
  Output<Wrench> out;
  int count = 0;
};

/// Passes on what triggers it, and works on two items a step.
class Relay final : public Node {
 public:
  struct Params {};
  Relay(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Relay>("sample.relay", "Passes on.")
        .input("in", &Relay::in, {.doc = "what comes", .trigger = Trigger::yes})
        .output("out", &Relay::out, "what goes")
        .info();
  }
  void step(StepContext& context) override {
    context.add_work(2);
    step_times.push_back(context.now());
    Stamped<Wrench> message;
    if (in.pop(message)) out.send(message.stamp.valid, message.value);
  }
  Input<Wrench> in;
  Output<Wrench> out;
  std::vector<Time> step_times;
};

/// Keeps everything that arrives, with the time of the step.
class Keep final : public Node {
 public:
  struct Params {};
  Keep(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Keep>("sample.keep", "Keeps.")
        .sink()
        .input(
            "in", &Keep::in,
            {.doc = "what comes", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 64}, .reference = true})
        .info();
  }
  struct Entry {
    Time now;
    Stamp stamp;
    double value;
  };
  void step(StepContext& context) override {
    for (Stamped<Wrench> m; in.pop(m);) kept.push_back({context.now(), m.stamp, m.value.force.x});
  }
  Input<Wrench> in;
  std::vector<Entry> kept;
};

/// counter -> relay (with a cost) -> keep.
struct SamplePlan {
  NodeInfo counter = Counter::declare();
  NodeInfo relay = Relay::declare();
  NodeInfo keep = Keep::declare();
  Plan plan;

  explicit SamplePlan(CostModel cost, double duration_s, Queue relay_queue = {}) {
    plan.graph.duration = Duration::from_seconds(duration_s);
    plan.nodes = {{"counter", &counter, {1000.0}, {}, {}, {}},
                  {"relay", &relay, {}, cost, {}, {}},
                  {"keep", &keep, {}, {}, {}, {}}};
    PlannedEdge first;
    first.spec = {"counter", "out", "relay", "in", relay_queue, true, {}, {}};
    first.from = 0;
    first.to = 1;
    first.triggers = true;
    PlannedEdge second;
    second.spec = {"relay", "out", "keep", "in", {QueuePolicy::drop_oldest, 64}, true, {}, {}};
    second.from = 1;
    second.to = 2;
    second.triggers = true;
    plan.edges = {first, second};
  }
};

}  // namespace tactor::sample
