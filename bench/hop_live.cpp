#include "bench/hop_live.hpp"

#include "framework/core/check.hpp"
#include "framework/engine/live/live_engine.hpp"
#include "framework/node/declare.hpp"
#include "tests/framework/engine/live/drive.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"

namespace tactor::bench {

namespace {

class Sender final : public Node {
 public:
  struct Params {
    double rate = 1000;
  };
  Sender(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Sender>("bench.sender", "Sends.")
        .output("out", &Sender::out, "when it was sent")
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 1000})
        .info();
  }
  void step(StepContext& context) override { out.send(context.now(), meter->message()); }
  Output<Wrench> out;
  HopMeter* meter = nullptr;
};

class Receiver final : public Node {
 public:
  struct Params {};
  Receiver(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Receiver>("bench.receiver", "Receives.")
        .sink()
        .input("in", &Receiver::in, {.doc = "when it was sent", .trigger = Trigger::yes})
        .info();
  }
  void step(StepContext&) override { meter->received(in.latest()->value); }
  Input<Wrench> in;
  HopMeter* meter = nullptr;
};

}  // namespace

void hop_by_live_run(bool detached, int workers, const ThreadSettings& threads, Duration duration, HopMeter& meter) {
  const NodeInfo sender = Sender::declare();
  const NodeInfo receiver = Receiver::declare();
  sample::PlanBuilder b(duration.seconds());
  b.plan.graph.live.pool = threads;
  b.plan.graph.live.pool_workers = workers;
  const Scheduling own{Lane::thread, "", threads.policy, threads.priority, threads.cpu};
  const std::size_t from = b.node("sender", sender, {1000.0}, detached ? own : Scheduling{});
  const std::size_t to = b.node("receiver", receiver, {});
  b.edge(from, to, 0, {}, true);
  LiveEngine run(b.plan);
  dynamic_cast<Sender&>(run.nodes()[from]).meter = &meter;
  dynamic_cast<Receiver&>(run.nodes()[to]).meter = &meter;
  sample::drive(run);
  if (run.failure()) throw RunError(*run.failure());
}

}  // namespace tactor::bench
