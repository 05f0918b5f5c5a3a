// Two clocks, one meaning: a live run whose costs are given to the virtual clock takes the same steps with the same
// values.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cstring>
#include <tuple>

#include "framework/core/clock.hpp"
#include "framework/engine/virtual_engine.hpp"
#include "tests/framework/engine/live/drive.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"
#include "tests/framework/engine/sample_nodes.hpp"

BOOST_AUTO_TEST_SUITE(live_contract_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

struct Infos {
  NodeInfo counter = Counter::declare();
  NodeInfo worker = Worker::declare();
  NodeInfo keep = Keep::declare();
};

/// A loop of two heavy nodes on one thread, as collision and dynamics are, light nodes behind queues of every policy
/// but `block`, a delayed edge and two rates.
Plan contract_plan(const Infos& infos, double duration_s) {
  PlanBuilder b(duration_s);
  const Scheduling physics{Lane::thread, "physics", {}, {}, {}};
  const Scheduling alone{Lane::thread, "", {}, {}, {}};
  const auto counter = b.node("counter", infos.counter, {1000.0});
  const auto slow = b.node("slow", infos.counter, {70.0});
  const auto heavy = b.node("heavy", infos.worker, {0.006}, physics);
  const auto after = b.node("after", infos.worker, {0.001}, physics);
  const auto light = b.node("light", infos.worker, {0.0003});
  const auto lossy = b.node("lossy", infos.worker, {0.004}, alone);
  const auto late = b.node("late", infos.worker, {0.0001});
  const auto fast = b.node("fast", infos.counter, {700.0});
  const auto patient = b.node("patient", infos.worker, {0.003}, alone);
  const auto keep = b.node("keep", infos.keep, {});
  b.edge(counter, heavy, 0, {}, true);
  b.edge(after, heavy, 1, {}, false);
  b.edge(heavy, after, 0, {}, true);
  b.edge(after, light, 0, {QueuePolicy::drop_oldest, 8}, true);
  b.edge(counter, lossy, 0, {QueuePolicy::drop_newest, 2}, true);
  b.edge(slow, lossy, 1, {}, false);
  b.edge(lossy, late, 0, {QueuePolicy::drop_oldest, 2}, true, {1'300'000});
  b.edge(light, late, 1, {}, false);
  b.edge(light, keep, 0, {QueuePolicy::drop_oldest, 64}, true);
  b.edge(fast, patient, 0, {QueuePolicy::block, 3}, true);
  for (const auto n : {counter, slow, heavy, after, light, lossy, late, fast, patient}) b.record(n);
  return b.plan;
}

/// The plan with the costs that `log` tells, in the order of each node's steps.
Plan with_costs(Plan plan, const EngineLog& log) {
  plan.graph.clock = Clock::virtual_;
  for (NodeSpec& node : plan.nodes) {
    node.cost = {};
    node.cost.kind = CostModel::Kind::trace;
  }
  std::vector<Step> steps = log.steps;
  std::sort(steps.begin(), steps.end());
  for (const auto& [now, node, cost] : steps) plan.nodes[node].cost.trace.push_back({cost});
  for (NodeSpec& node : plan.nodes) {
    // A step that had not passed at the end is in no log; it costs more than is left.
    node.cost.trace.push_back(plan.graph.duration * 2);
  }
  return plan;
}

/// The steps that had passed by the end, in order.
std::vector<Step> passed(std::vector<Step> steps, const Plan& plan) {
  std::erase_if(steps, [&](const Step& s) { return std::get<0>(s) + std::get<2>(s) >= plan.graph.duration.ns; });
  std::sort(steps.begin(), steps.end());
  return steps;
}

struct Sorted {
  std::vector<LoggedMessage> messages;
  std::vector<double> values;
};

/// The messages that were visible before the end, by stream and sequence.
Sorted visible(const EngineLog& log, const Plan& plan) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < log.messages.size(); ++i) {
    if (std::get<3>(log.messages[i]) < plan.graph.duration.ns) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return log.messages[a] < log.messages[b]; });
  Sorted result;
  for (const std::size_t i : order) {
    result.messages.push_back(log.messages[i]);
    result.values.push_back(log.values[2 * i]);
    result.values.push_back(log.values[2 * i + 1]);
  }
  return result;
}

/// Runs the plan live and again under the virtual clock with the costs it had: the same steps and values; what the live
/// run told.
std::vector<Step> check_contract(const Plan& plan) {
  LiveEngine run(plan);
  EngineLog live(run, plan);
  drive(
      run, [](const EngineStatus&) { return true; }, [&] { live.take(); });
  BOOST_TEST(live.dropped() == 0U);
  BOOST_REQUIRE_MESSAGE(!run.failure(), run.failure().value_or(""));

  const Plan again = with_costs(plan, live);
  VirtualEngine clock(again);
  EngineLog replay(clock, again);
  clock.run();
  replay.take();

  const auto live_steps = passed(live.steps, plan);
  const auto replay_steps = passed(replay.steps, plan);
  BOOST_TEST(live_steps.size() > 500U);
  BOOST_REQUIRE(live_steps.size() == replay_steps.size());
  for (std::size_t i = 0; i < live_steps.size(); ++i) {
    BOOST_REQUIRE_MESSAGE(live_steps[i] == replay_steps[i], "step " << i << ": live node " << std::get<1>(live_steps[i])
                                                                    << " at " << std::get<0>(live_steps[i])
                                                                    << ", replay node " << std::get<1>(replay_steps[i])
                                                                    << " at " << std::get<0>(replay_steps[i]));
  }
  const Sorted a = visible(live, plan);
  const Sorted b = visible(replay, plan);
  BOOST_TEST(a.messages.size() > 500U);
  BOOST_REQUIRE(a.messages == b.messages);
  BOOST_REQUIRE(a.values.size() == b.values.size());
  for (std::size_t i = 0; i < a.values.size(); ++i) BOOST_REQUIRE_SMALL(a.values[i] - b.values[i], 1e-12);
  // The lossy queue lost the same in both.
  BOOST_TEST(run.status().edges[4].metrics.dropped > 0U);
  return live.steps;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_live_run_given_its_costs_is_the_same_run_under_the_virtual_clock) {
  const Infos infos;
  check_contract(contract_plan(infos, 2.0));
}

BOOST_AUTO_TEST_CASE(a_live_run_that_imposes_costs_is_the_same_run_under_the_virtual_clock) {
  const Infos infos;
  Plan plan = contract_plan(infos, 2.0);
  plan.graph.live.impose_cost = true;
  std::vector<CostDraw> declared;
  for (NodeSpec& node : plan.nodes) {
    if (node.name == "heavy") {
      node.cost.kind = CostModel::Kind::constant;
      node.cost.base = Duration{9'000'000};
      node.cost.jitter = 0.1;
    }
    if (node.name == "light") {
      node.cost.kind = CostModel::Kind::constant;
      node.cost.base = Duration{2'000'000};
    }
    declared.emplace_back(node.cost, plan.graph.seed, node.name);
  }
  // No step passes before the cost that the virtual clock would have drawn for it, be it long or short.
  std::vector<Step> steps = check_contract(plan);
  std::sort(steps.begin(), steps.end());
  std::vector<std::size_t> count(plan.nodes.size());
  for (const auto& [now, node, cost] : steps) {
    BOOST_TEST(cost >= declared[node].next(0).ns);
    ++count[node];
  }
  // By name, as contract_plan has them.
  BOOST_TEST(plan.nodes[2].name == "heavy");
  BOOST_TEST(count[2] > 20U);
  BOOST_TEST(count[2] <= 2'000'000'000U / 6'300'000U + 1);  // the jitter is cut at three of its deviations
}

BOOST_AUTO_TEST_CASE(results_that_are_held_back_take_no_time_of_a_core_and_are_no_stall) {
  CostModel cost;
  cost.kind = CostModel::Kind::constant;
  cost.base = Duration{400'000'000};
  SamplePlan sample(cost, 1.0);
  sample.plan.graph.live.impose_cost = true;
  sample.plan.graph.live.stall_timeout = Duration{100'000'000};
  LiveEngine run(sample.plan);
  const double before = clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
  drive(run);
  BOOST_TEST(!run.failure().has_value());
  BOOST_TEST(run.status().nodes[1].steps >= 2U);
  BOOST_TEST(run.status().nodes[1].steps <= 3U);
  BOOST_TEST(!run.status().nodes[1].stalled);
  // Who spins takes a second of it.
  BOOST_TEST(clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - before < 0.7);
  for (const Keep::Entry& entry : dynamic_cast<const Keep&>(run.nodes()[2]).kept) {
    BOOST_TEST((entry.stamp.produced - entry.stamp.valid).ns >= cost.base.ns);
  }
}

BOOST_AUTO_TEST_CASE(costs_are_not_imposed_unless_the_graph_says_so_and_outlast_no_run) {
  CostModel cost;
  cost.kind = CostModel::Kind::constant;
  cost.base = Duration{3'000'000'000};
  for (const bool imposed : {false, true}) {
    SamplePlan sample(cost, 0.3);
    sample.plan.graph.live.impose_cost = imposed;
    LiveEngine run(sample.plan);
    drive(run);
    BOOST_TEST(!run.failure().has_value());
    BOOST_TEST(!run.is_abandoned());
    BOOST_TEST((run.status().nodes[1].steps == 1U) == imposed);
  }
}

BOOST_AUTO_TEST_SUITE_END()
