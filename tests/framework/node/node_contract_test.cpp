// Ports keep their queue policies, declarations become data, and values reach the typed struct.
#include <boost/test/unit_test.hpp>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/registry.hpp"
#include "nodes/prediction/ar_coefficients.hpp"

BOOST_AUTO_TEST_SUITE(node_contract_test)

using namespace tactor;

namespace {

class Gain final : public Node {
 public:
  enum class Mode { linear, squared };
  struct Params {
    double gain = 0;
    Duration delay;
    std::int32_t order = 0;
    Mode mode = Mode::linear;
  };
  Gain(const Params& p, const NodeContext&) : params(p) {}
  static NodeInfo declare() {
    return Declare<Gain>("test.gain", "Multiplies.")
        .input("in", &Gain::in, {.doc = "what comes", .trigger = Trigger::yes})
        .ignored_when([](const Params& p) { return p.gain == 0 ? std::string("gain is 0") : std::string(); })
        .output("out", &Gain::out, "what goes")
        .real("gain", &Params::gain, {.doc = "factor", .default_value = 2, .min = 0})
        .real("delay", &Params::delay, {.doc = "later", .unit = "s", .default_value = 0.001})
        .integer("order", &Params::order, {.doc = "order", .default_value = 3, .min = 1, .max = 9})
        .choice("mode", &Params::mode, {{"linear", Mode::linear}, {"squared", Mode::squared}},
                std::optional(Mode::squared), "how")
        .role(Role::coupling)
        .metric("gain.largest_N", "N", "largest output", Better::lower)
        .missing_where("nothing comes")
        .left_out_when([](const Params& p, const MetricUse& use) {
          return std::string(p.gain == 0 ? "gain is 0" : use.is_fed("in") ? "" : "nothing feeds in");
        })
        .metric("passed", "1", "messages", Better::neither)
        .summed()
        .info();
  }
  void step(StepContext&) override {
    const Stamped<Wrench>* message = in.latest();
    out.send(message->stamp.valid, params.gain * message->value);
  }

  Params params;
  Input<Wrench> in;
  Output<Wrench> out;
};

Stamp at(std::int64_t ns, std::uint64_t sequence = 0) {
  return {Time{ns}, Time{ns}, sequence};
}

}  // namespace

BOOST_AUTO_TEST_CASE(declared_defaults_reach_the_typed_struct) {
  const NodeInfo info = Gain::declare();
  std::vector<ParamValue> values;
  for (const ParamInfo& p : info.params) values.push_back(p.default_value.value());
  const Scene scene;
  NodeContext context;
  context.scene = &scene;
  const std::unique_ptr<Node> node = info.create(values, context);
  const auto& gain = dynamic_cast<const Gain&>(*node);
  BOOST_TEST(gain.params.gain == 2.0);
  BOOST_TEST(gain.params.delay.ns == 1'000'000);
  BOOST_TEST(gain.params.order == 3);
  BOOST_TEST((gain.params.mode == Gain::Mode::squared));
  BOOST_TEST(info.inputs[0].ignored(values).empty());
  values[0] = 0.0;
  BOOST_TEST(info.inputs[0].ignored(values) == "gain is 0");
}

BOOST_AUTO_TEST_CASE(no_parameter_has_the_name_of_a_key_that_every_node_has) {
  for (const std::string_view key : node_keys) {
    NodeInfo info = Gain::declare();
    info.params[0].name = key;
    const std::string expected = "the node type test.gain declares the parameter \"" + std::string(key) + "\"";
    Registry registry({});
    BOOST_CHECK_EXCEPTION(registry.add(info), InputError,
                          [&](const InputError& e) { return std::string_view(e.what()).starts_with(expected); });
    BOOST_TEST(registry.types().empty());
  }
  Registry registry({});
  registry.add<Gain>();
  BOOST_TEST(registry.types().size() == 1U);
}

BOOST_AUTO_TEST_CASE(a_type_of_the_realtime_lane_is_safe_and_has_a_rate) {
  const auto refusal = [](const NodeInfo& info) {
    Registry registry({});
    try {
      registry.add(info);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  NodeInfo info = Gain::declare();
  info.lane = Lane::realtime;
  BOOST_TEST(refusal(info).find("found steps that are not") != std::string::npos);
  info.realtime_safe = true;
  BOOST_TEST(refusal(info).find("found no rate") != std::string::npos);
  info.rate_parameter = 0;
  BOOST_TEST(refusal(info) == "");
}

BOOST_AUTO_TEST_CASE(latest_keeps_the_newest_and_counts_what_it_replaced) {
  Input<Wrench> in;
  in.configure({QueuePolicy::latest, 1});
  BOOST_TEST(in.latest() == nullptr);
  for (int i = 0; i < 5; ++i) {
    const Wrench w{{double(i), 0, 0}, {}};
    in.push(at(i), &w);
  }
  BOOST_TEST(in.latest()->value.force.x == 4.0);
  BOOST_TEST(in.queue().superseded() == 4U);
  in.queue().mark_seen();
  BOOST_TEST(in.unread() == 0U);
  BOOST_TEST(in.latest()->stamp.valid.ns == 4);
}

BOOST_AUTO_TEST_CASE(drop_oldest_keeps_the_last_and_drop_newest_the_first) {
  for (const QueuePolicy policy : {QueuePolicy::drop_oldest, QueuePolicy::drop_newest}) {
    Input<Wrench> in;
    in.configure({policy, 3});
    for (int i = 0; i < 5; ++i) {
      const Wrench w{{double(i), 0, 0}, {}};
      in.push(at(i), &w);
    }
    BOOST_TEST(in.queue().dropped() == 2U);
    std::vector<double> taken;
    for (Stamped<Wrench> m; in.pop(m);) taken.push_back(m.value.force.x);
    const std::vector<double> expected =
        policy == QueuePolicy::drop_oldest ? std::vector<double>{2, 3, 4} : std::vector<double>{0, 1, 2};
    BOOST_TEST(taken == expected, boost::test_tools::per_element());
  }
}

BOOST_AUTO_TEST_CASE(a_blocking_queue_says_when_it_is_full) {
  Input<Wrench> in;
  in.configure({QueuePolicy::block, 2});
  const Wrench w{};
  in.push(at(0), &w);
  BOOST_TEST(!in.full());
  in.push(at(1), &w);
  BOOST_TEST(in.full());
  Stamped<Wrench> m;
  BOOST_TEST(in.pop(m));
  BOOST_TEST(!in.full());
}

BOOST_AUTO_TEST_CASE(metrics_are_declared_with_unit_direction_and_when_they_are_left_out) {
  const NodeInfo info = Gain::declare();
  BOOST_TEST(name_of(info.role) == "coupling");
  BOOST_TEST((role_of("coupling") == Role::coupling));
  BOOST_TEST((role_of("nothing") == Role::other));
  BOOST_REQUIRE(info.metrics.size() == 2U);
  const MetricInfo& largest = info.metrics[0];
  BOOST_TEST(largest.unit == "N");
  BOOST_TEST(name_of(largest.better) == "lower");
  BOOST_TEST(largest.missing == "nothing comes");
  std::vector<ParamValue> values;
  for (const ParamInfo& p : info.params) values.push_back(p.default_value.value());
  BOOST_TEST(largest.left_out(values, {.inputs = {"in"}}) == "");
  BOOST_TEST(largest.left_out(values, {}) == "nothing feeds in");
  values[0] = 0.0;
  BOOST_TEST(largest.left_out(values, {.inputs = {"in"}}) == "gain is 0");
  BOOST_TEST(info.metrics[1].summed);
  BOOST_TEST(!info.metrics[1].left_out);
}

BOOST_AUTO_TEST_CASE(a_report_refuses_metrics_that_the_node_does_not_declare) {
  const NodeInfo info = Gain::declare();
  Report report;
  const auto refusal = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const RunError& error) {
      return error.what();
    }
    return "no error";
  };
  report.begin("gain", info.metrics);
  report.set("gain.largest_N", 2);
  BOOST_TEST(refusal([&] { report.set("gain.larges_N", 2); }) ==
             "node gain reports the metric gain.larges_N, which its type does not declare, or declares as left out "
             "here; correct the declaration");
  BOOST_TEST(refusal([&] { report.add("gain.largest_N", 2); }) ==
             "node gain reports the metric gain.largest_N by adding to it, and its type does not declare it as a sum; "
             "correct the declaration");
  BOOST_TEST(refusal([&] { report.set("passed", 2); }) ==
             "node gain reports the metric passed by setting it, and its type declares it as a sum; correct the "
             "declaration");
  report.begin("next", {});
  BOOST_TEST(refusal([&] { report.set("gain.largest_N", 2); }).starts_with("node next reports"));
  BOOST_TEST(report.metrics().size() == 1U);
}

BOOST_AUTO_TEST_CASE(a_metric_is_a_member_or_a_function_of_its_node) {
  struct Counter final : Node {
    struct Params {};
    Counter() = default;
    Counter(const Params&, const NodeContext&) {}
    void step(StepContext&) override {}
    void report(Report& report) const override { report.set("counter.said", 4); }
    [[nodiscard]] std::int64_t twice() const { return 2 * count; }
    int count = 3;
    std::optional<double> share;
  };
  Declare<Counter> declaration("sample.counter", "Counts.");
  declaration.metric("counter.count", "1", "a member", Better::neither, &Counter::count)
      .metric("counter.twice", "1", "a function", Better::neither, &Counter::twice)
      .metric("counter.all", "1", "a sum", Better::neither, [](const Counter& node) { return node.count; })
      .summed()
      .metric("counter.share", "1", "not in each run", Better::neither, &Counter::share)
      .metric("counter.said", "1", "set by report()", Better::neither);
  const std::vector<MetricInfo> metrics = declaration.info().metrics;
  Counter node;
  Report report;
  report.ask(node, "a", metrics);
  node.share = 0.5;
  report.ask(node, "b", metrics);
  const std::vector<std::pair<std::string, double>> expected{
      {"counter.count", 3},   {"counter.twice", 6},   {"counter.all", 6},     {"counter.said", 4},
      {"b.counter.count", 3}, {"b.counter.twice", 6}, {"counter.share", 0.5}, {"b.counter.said", 4}};
  BOOST_TEST((report.metrics() == expected));
}

BOOST_AUTO_TEST_CASE(the_metrics_of_a_second_node_have_its_name_and_sums_have_one) {
  const NodeInfo info = Gain::declare();
  Report report;
  report.begin("", info.metrics);
  report.add("passed", 0);
  report.set("gain.largest_N", 0);  // the program's, until a node sets it
  for (const auto& [node, value] : {std::pair{"a", 1.0}, {"b", 2.0}}) {
    report.begin(node, info.metrics);
    report.set("gain.largest_N", value);
    report.add("passed", value);
  }
  const std::vector<std::pair<std::string, double>> expected{
      {"passed", 3}, {"gain.largest_N", 1}, {"b.gain.largest_N", 2}};
  BOOST_TEST((report.metrics() == expected));
}

BOOST_AUTO_TEST_CASE(a_type_that_declares_a_metric_twice_is_refused) {
  NodeInfo info = Gain::declare();
  info.metrics.push_back(info.metrics.front());
  Registry registry{{}};
  BOOST_CHECK_EXCEPTION(registry.add(info), InputError, [](const InputError& error) {
    return std::string(error.what()) ==
           "the node type test.gain declares the metric gain.largest_N twice; declare it once";
  });
}

BOOST_AUTO_TEST_SUITE_END()
