// Ports keep their queue policies, declarations become data, and values reach the typed struct.
#include <boost/test/unit_test.hpp>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/registry.hpp"
#include "nodes/prediction/ar_coefficients.hpp"

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
