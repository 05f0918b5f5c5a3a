// What a program feeds goes along an edge as the messages of a node do, with every policy.
#include <boost/test/unit_test.hpp>
#include <thread>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/node/plugin.hpp"
#include "framework/session/session.hpp"
#include "tests/framework/engine/sample_nodes.hpp"

BOOST_AUTO_TEST_SUITE(feed_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

constexpr std::int64_t ms = 1'000'000;

/// What a program sends for.
class Fed final : public Node {
 public:
  struct Params {};
  Fed(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Fed>("sample.fed", "Is fed.").fed().output("out", &Fed::out, "what comes").info();
  }
  void step(StepContext& /*context*/) override { BOOST_FAIL("it steps"); }
  Output<Wrench> out;
};

/// Longer than the period of what comes, and at no instant together with it.
CostModel slow() {
  CostModel cost;
  cost.kind = CostModel::Kind::constant;
  cost.base = Duration{5'317'100};
  return cost;
}

const std::vector<Queue> queues{
    {QueuePolicy::latest, 1}, {QueuePolicy::drop_oldest, 3}, {QueuePolicy::drop_newest, 3}, {QueuePolicy::block, 3}};

using Kept = std::vector<std::tuple<std::int64_t, std::int64_t, std::uint64_t, double>>;

Kept kept_by(Session& session) {
  Kept kept;
  for (const Keep::Entry& e : dynamic_cast<const Keep&>(session.nodes()[2]).kept) {
    kept.emplace_back(e.now.ns, e.stamp.valid.ns, e.stamp.sequence, e.value);
  }
  return kept;
}

}  // namespace

BOOST_AUTO_TEST_CASE(what_is_fed_goes_the_way_of_what_a_node_sends_with_every_policy) {
  for (const Queue& queue : queues) {
    SamplePlan by_node(slow(), 0.1, queue);
    Session counting(by_node.plan);
    counting.start();
    counting.advance(Duration{100 * ms});
    const EdgeStatistics expected = counting.edge_statistics(0);

    SamplePlan by_program(slow(), 0.1, queue);
    const NodeInfo fed = Fed::declare();
    by_program.plan.nodes[0] = {"counter", &fed, {}, {}, {}, {}};
    Session session(by_program.plan);
    Session::Feed feed = session.feed("relay.in");
    session.start();
    double value = 0;
    for (int i = 0; i < 100; ++i) {
      session.advance(Duration{i * ms} - (session.now() - Time{}));
      if (feed.send(Wrench{{value, 0, 0}, {}})) value += 1;
    }
    session.advance(Duration{1 * ms});
    const EdgeStatistics found = session.edge_statistics(0);
    BOOST_TEST(kept_by(session).size() > 10U);
    BOOST_CHECK(kept_by(session) == kept_by(counting));
    BOOST_TEST(found.delivered == expected.delivered);
    BOOST_TEST(found.dropped == expected.dropped);
    BOOST_TEST(found.superseded == expected.superseded);
    BOOST_TEST((queue.policy == QueuePolicy::block) == (value < 50));
  }
}

BOOST_AUTO_TEST_CASE(a_program_feeds_a_live_run_from_another_thread) {
  if (!has_plugin("libtactor_live.so")) {
    BOOST_TEST_MESSAGE("this build has no live engine");
    return;
  }
  for (const Queue& queue : queues) {
    SamplePlan plan({}, 30, queue);
    plan.plan.graph.clock = Clock::real;
    const NodeInfo fed = Fed::declare();
    plan.plan.nodes[0] = {"counter", &fed, {}, {}, {}, {}};
    Session session(plan.plan);
    Session::Feed feed = session.feed("counter");
    session.start();
    std::uint64_t sent = 0;
    std::thread program([&] {
      for (int i = 0; i < 200; ++i) {
        if (feed.send(Wrench{{static_cast<double>(sent), 0, 0}, {}})) ++sent;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
    session.advance(Duration{100 * ms});
    program.join();
    session.advance(Duration{100 * ms});
    session.stop();
    session.finish();
    BOOST_TEST(!session.failure().has_value());
    const EdgeStatistics edge = session.edge_statistics(0);
    BOOST_TEST(edge.delivered == sent);
    const Kept kept = kept_by(session);
    BOOST_TEST(kept.size() + edge.dropped + edge.superseded == sent);
    BOOST_TEST(kept.size() > 50U);
    for (std::size_t i = 1; i < kept.size(); ++i) BOOST_TEST(std::get<3>(kept[i]) > std::get<3>(kept[i - 1]));
  }
}

BOOST_AUTO_TEST_CASE(a_feed_that_is_not_there_is_told_with_the_nearest) {
  SamplePlan plan({}, 1);
  Session session(plan.plan);
  BOOST_CHECK_EXCEPTION(static_cast<void>(session.feed("relay.in")), InputError, [](const InputError& error) {
    return std::string(error.what()).find("no feed relay.in") != std::string::npos;
  });
}

BOOST_AUTO_TEST_SUITE_END()
