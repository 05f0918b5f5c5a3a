// The semantics of the virtual clock on plans small enough to work out by hand.
#include "framework/engine/virtual_engine.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "tests/framework/engine/engine_log.hpp"
#include "tests/framework/engine/sample_nodes.hpp"

BOOST_AUTO_TEST_SUITE(virtual_engine_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

constexpr std::int64_t ms = 1'000'000;

CostModel constant(std::int64_t ns) {
  CostModel cost;
  cost.kind = CostModel::Kind::constant;
  cost.base = {ns};
  return cost;
}

/// Sends the number of its step, and notes what came back of the numbers sent before.
class Asker final : public Node {
 public:
  struct Params {};
  Asker(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Asker>("sample.asker", "Asks.")
        .input("in", &Asker::in, {.doc = "what makes it step", .trigger = Trigger::yes})
        .input("back", &Asker::back, {.doc = "the answer"})
        .output("out", &Asker::out, "the question")
        .info();
  }
  void step(StepContext& context) override {
    answers.push_back(back.latest() == nullptr ? -1 : back.latest()->value.force.x);
    out.send(context.now(), {{static_cast<double>(answers.size() - 1), 0, 0}, {}});
  }
  Input<Wrench> in, back;
  Output<Wrench> out;
  std::vector<double> answers;
};

const Keep& kept(VirtualEngine& engine) {
  return dynamic_cast<const Keep&>(engine.nodes()[2]);
}

}  // namespace

BOOST_AUTO_TEST_CASE(without_costs_a_message_passes_the_whole_chain_in_one_instant) {
  const SamplePlan sample({}, 0.005);
  VirtualEngine engine(sample.plan);
  engine.run();
  const auto& entries = kept(engine).kept;
  BOOST_REQUIRE(entries.size() == 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    BOOST_TEST(entries[i].now.ns == static_cast<std::int64_t>(i) * ms);
    BOOST_TEST(entries[i].stamp.valid.ns == entries[i].now.ns);
    BOOST_TEST(entries[i].stamp.produced.ns == entries[i].now.ns);
    BOOST_TEST(entries[i].stamp.sequence == i);
    BOOST_TEST(entries[i].value == static_cast<double>(i));
  }
}

BOOST_AUTO_TEST_CASE(a_result_becomes_visible_after_its_cost_and_a_busy_node_runs_freely_on_the_latest) {
  // Counter at 0, 1, 2, ... ms; the relay takes 2.5 ms: it starts at 0, 2.5, 5, ... on the newest count there is.
  const SamplePlan sample(constant(5 * ms / 2), 0.011);
  VirtualEngine engine(sample.plan);
  engine.run();
  const auto& entries = kept(engine).kept;
  const double newest[] = {0, 2, 5, 7};
  BOOST_REQUIRE(entries.size() == 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    BOOST_TEST(entries[i].now.ns == static_cast<std::int64_t>(i + 1) * 5 * ms / 2);
    BOOST_TEST(entries[i].value == newest[i]);
    BOOST_TEST(entries[i].stamp.valid.ns == static_cast<std::int64_t>(newest[i]) * ms);
  }
  // Counts 1, 3, 4, 6, 8, 9 were replaced before the relay looked; 10 came while it was busy with 10 at 10 ms.
  BOOST_TEST(engine.edge_statistics(0).superseded == 6U);
  BOOST_TEST(engine.edge_statistics(0).dropped == 0U);
}

BOOST_AUTO_TEST_CASE(a_queue_keeps_order_and_drops_what_its_policy_says) {
  for (const QueuePolicy policy : {QueuePolicy::drop_oldest, QueuePolicy::drop_newest}) {
    const SamplePlan sample(constant(5 * ms / 2), 0.011, {policy, 2});
    VirtualEngine engine(sample.plan);
    engine.run();
    std::vector<double> values;
    for (const auto& e : kept(engine).kept) values.push_back(e.value);
    // At 2.5 ms {1, 2} wait, at 5 ms of {2, 3, 4, 5} two fit, and so on.
    const std::vector<double> expected =
        policy == QueuePolicy::drop_oldest ? std::vector<double>{0, 1, 4, 6} : std::vector<double>{0, 1, 2, 3};
    BOOST_TEST(values == expected, boost::test_tools::per_element());
    BOOST_TEST(engine.edge_statistics(0).dropped > 0U);
  }
}

BOOST_AUTO_TEST_CASE(a_blocking_queue_loses_nothing_and_makes_its_writer_miss_ticks) {
  const SamplePlan sample(constant(5 * ms / 2), 0.050, {QueuePolicy::block, 2});
  VirtualEngine engine(sample.plan);
  engine.run();
  const auto& entries = kept(engine).kept;
  BOOST_REQUIRE(entries.size() > 10U);
  for (std::size_t i = 0; i < entries.size(); ++i) BOOST_TEST(entries[i].value == static_cast<double>(i));
  BOOST_TEST(engine.edge_statistics(0).dropped == 0U);
  BOOST_TEST(engine.node_statistics(0).missed_ticks > 20U);
}

BOOST_AUTO_TEST_CASE(a_node_whose_cost_is_its_period_misses_no_tick) {
  SamplePlan sample({}, 0.010);
  sample.plan.nodes[0].cost = constant(ms);
  VirtualEngine engine(sample.plan);
  engine.run();
  BOOST_TEST(engine.node_statistics(0).missed_ticks == 0U);
  BOOST_TEST(engine.node_statistics(0).steps == 10U);
}

BOOST_AUTO_TEST_CASE(a_node_that_is_triggered_while_busy_sees_the_answer_to_what_it_has_just_sent) {
  // counter -> asker (2.5 ms a step) -> relay -> back to the asker, as collision and dynamics are connected.
  const NodeInfo asker = Asker::declare();
  SamplePlan sample({}, 0.050);
  sample.plan.nodes[1] = {"asker", &asker, {}, constant(5 * ms / 2), {}};
  sample.plan.nodes[2] = {"relay", &sample.relay, {}, {}, {}};
  PlannedEdge& question = sample.plan.edges[1];
  question.spec = {"asker", "out", "relay", "in", {}, true, {}, {}};
  PlannedEdge answer = question;
  answer.spec = {"relay", "out", "asker", "back", {}, true, {}, {}};
  answer.from = 2;
  answer.to = 1;
  answer.input = 1;
  answer.triggers = false;
  sample.plan.edges.push_back(answer);
  VirtualEngine engine(sample.plan);
  engine.run();
  const std::vector<double>& answers = dynamic_cast<const Asker&>(engine.nodes()[1]).answers;
  BOOST_REQUIRE(answers.size() > 10U);
  for (std::size_t i = 0; i < answers.size(); ++i) BOOST_TEST(answers[i] == static_cast<double>(i) - 1);
}

BOOST_AUTO_TEST_CASE(nodes_that_share_a_thread_take_turns) {
  // Both relays are asked each millisecond and take three: neither is ever without work.
  SamplePlan sample(constant(3 * ms), 0.060);
  sample.plan.nodes[1].scheduling = {Lane::thread, "physics", {}, {}, {}};
  sample.plan.nodes.push_back(sample.plan.nodes[1]);
  sample.plan.nodes.back().name = "other";
  PlannedEdge edge = sample.plan.edges[0];
  edge.spec.to_node = "other";
  edge.to = 3;
  sample.plan.edges.push_back(edge);
  VirtualEngine engine(sample.plan);
  engine.run();
  for (const std::size_t node : {1U, 3U}) {
    const auto& times = dynamic_cast<const Relay&>(engine.nodes()[node]).step_times;
    BOOST_REQUIRE(times.size() == 10U);
    for (std::size_t i = 0; i < times.size(); ++i) {
      BOOST_TEST(times[i].ns == static_cast<std::int64_t>(6 * i + (node == 1 ? 0 : 3)) * ms);
    }
  }
}

BOOST_AUTO_TEST_CASE(an_edge_delay_adds_to_the_cost) {
  SamplePlan sample(constant(ms / 2), 0.010);
  sample.plan.edges[1].spec.delay = {3 * ms};
  VirtualEngine engine(sample.plan);
  engine.run();
  const auto& entries = kept(engine).kept;
  BOOST_REQUIRE(entries.size() == 7U);
  BOOST_TEST(entries[0].now.ns == 7 * ms / 2);
  BOOST_TEST(entries[6].now.ns == 6 * ms + 7 * ms / 2);
}

BOOST_AUTO_TEST_CASE(costs_follow_their_models) {
  CostModel per_item;
  per_item.kind = CostModel::Kind::per_item;
  per_item.base = {ms};
  per_item.each = {ms / 4};
  const SamplePlan sample(per_item, 0.004);
  VirtualEngine engine(sample.plan);
  EngineLog log(engine, sample.plan);
  engine.run();
  BOOST_TEST(log.text().find("1@0+1500000\n") != std::string::npos);

  CostModel trace;
  trace.kind = CostModel::Kind::trace;
  trace.trace = {{ms}, {2 * ms}, {3 * ms}};
  const SamplePlan traced_sample(trace, 0.013);
  VirtualEngine second(traced_sample.plan);
  EngineLog traced(second, traced_sample.plan);
  second.run();
  for (const char* step : {"1@0+1000000\n", "1@1000000+2000000\n", "1@3000000+3000000\n", "1@6000000+1000000\n"}) {
    BOOST_TEST(traced.text().find(step) != std::string::npos);
  }
}

BOOST_AUTO_TEST_CASE(jitter_has_the_stated_spread_and_is_the_seeds_alone) {
  CostModel cost = constant(10 * ms);
  cost.jitter = 0.1;
  const auto times = [&](std::uint64_t seed) {
    SamplePlan sample(cost, 20.0);
    sample.plan.graph.seed = seed;
    VirtualEngine engine(sample.plan);
    engine.run();
    std::vector<double> result;
    for (const auto& e : kept(engine).kept) result.push_back(e.now.seconds());
    return result;
  };
  const std::vector<double> a = times(1);
  double sum = 0;
  double square = 0;
  for (std::size_t i = 1; i < a.size(); ++i) sum += a[i] - a[i - 1];
  const double mean = sum / static_cast<double>(a.size() - 1);
  for (std::size_t i = 1; i < a.size(); ++i) square += std::pow(a[i] - a[i - 1] - mean, 2);
  // About 1,900 draws: the mean is known to 0.03 ms, the deviation to 2 %. Starts wait for the next count at most 1 ms.
  BOOST_TEST(std::abs(mean - 10.0e-3) < 0.6e-3);
  BOOST_TEST(std::abs(std::sqrt(square / static_cast<double>(a.size())) - 1e-3) < 0.15e-3);
  BOOST_TEST(a == times(1), boost::test_tools::per_element());
  BOOST_TEST((a != times(2)));
}

BOOST_AUTO_TEST_CASE(the_same_plan_gives_the_same_sequence_of_steps) {
  CostModel cost = constant(3 * ms);
  cost.jitter = 0.3;
  std::string first;
  for (int i = 0; i < 3; ++i) {
    const SamplePlan sample(cost, 2.0);
    VirtualEngine engine(sample.plan, {.measure_cpu = i == 1});
    EngineLog log(engine, sample.plan);
    engine.run();
    if (first.empty()) first = log.text();
    BOOST_TEST((first == log.text()));
  }
}

namespace {

class Thrower final : public Node {
 public:
  struct Params {
    double rate = 100;
  };
  Thrower(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Thrower>("sample.thrower", "Throws.")
        .sink()
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 100})
        .info();
  }
  void step(StepContext& context) override {
    if (context.now().ns > 0) throw std::runtime_error("the wire came off");
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_node_that_throws_ends_the_run_with_its_name_and_the_time) {
  const NodeInfo info = Thrower::declare();
  Plan plan;
  plan.graph.duration = Duration::from_seconds(1);
  plan.nodes = {{"wire", &info, {100.0}, {}, {}, {}}};
  VirtualEngine engine(plan);
  BOOST_CHECK_EXCEPTION(engine.run(), RunError, [](const RunError& error) {
    return std::string(error.what()).find("node wire failed at 0.01") == 0 &&
           std::string(error.what()).find("the wire came off") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(a_run_that_is_advanced_in_pieces_is_the_same_run) {
  CostModel cost = constant(3 * ms);
  cost.jitter = 0.3;
  const SamplePlan sample(cost, 1.0);
  VirtualEngine whole(sample.plan);
  EngineLog all(whole, sample.plan);
  whole.run();
  VirtualEngine cut(sample.plan);
  EngineLog pieces(cut, sample.plan);
  cut.start();
  // Pieces of all sizes, most of which end at no event, some at ticks, some of no length.
  for (std::int64_t i = 0; cut.now().seconds() < 1; ++i) {
    const Time next = cut.now() + Duration{i % 5 == 0 ? 0 : (i % 7) * 700'001 + (i % 3) * 1'000'000};
    cut.advance_to(std::min(next, Time{1'000'000'000}));
  }
  BOOST_TEST((all.text() == pieces.text()));
  BOOST_TEST(all.steps.size() > 1000U);
  BOOST_TEST(cut.node_statistics(1).steps == whole.node_statistics(1).steps);
}

BOOST_AUTO_TEST_CASE(a_tap_tells_from_when_it_is_added_until_it_is_taken_away) {
  const SamplePlan sample({}, 1.0);
  VirtualEngine engine(sample.plan);
  engine.start();
  engine.advance_to(Time{100 * ms});
  Tap tap(message_type<Wrench>(), {QueuePolicy::drop_oldest, 100});
  Tap small(message_type<Wrench>(), {QueuePolicy::drop_newest, 10});
  engine.dispatcher().add_tap(0, 0, tap);
  engine.dispatcher().add_tap(0, 0, small);
  engine.advance_to(Time{150 * ms});
  engine.dispatcher().remove_tap(tap);
  engine.dispatcher().remove_tap(small);
  engine.advance_to(Time{300 * ms});
  for (std::uint64_t i = 100; i < 150; ++i) {
    const MessageView view = tap.take();
    BOOST_REQUIRE(static_cast<bool>(view));
    BOOST_REQUIRE(view.stamp->sequence == i);
  }
  BOOST_TEST(!tap.take());
  BOOST_TEST(tap.dropped() == 0U);
  BOOST_TEST(small.dropped() == 40U);
  BOOST_TEST(small.take().stamp->sequence == 100U);
}

BOOST_AUTO_TEST_SUITE_END()
