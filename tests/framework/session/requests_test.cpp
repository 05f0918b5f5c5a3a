// What nodes ask of their run: to set a parameter of another node, and to end it.
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <map>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "framework/core/value_error.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/node/plugin.hpp"
#include "framework/node/set_request.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/session/session.hpp"
#include "tests/framework/engine/sample_nodes.hpp"
#include "tests/support/needs_live.hpp"

BOOST_AUTO_TEST_SUITE(requests_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

constexpr std::int64_t request_ms = 1'000'000;

/// Sends its parameter at a rate.
class Sender final : public Node {
 public:
  struct Params {
    double k = 0, k_max = 0;
    double rate = 1000;
  };
  Sender(const Params& params, const NodeContext& context) : params_(params) {
    if (params.k > params.k_max) context.note_limit("k", "k_max", "k is held at k_max");
  }
  static NodeInfo declare() {
    return Declare<Sender>("sample.sender", "Sends its parameter.")
        .output("out", &Sender::out, "k")
        .real("k", &Params::k, {.doc = "what it sends", .unit = "N/m", .default_value = 500, .min = 0, .max = 2000})
        .real("k_max", &Params::k_max, {.doc = "the most", .unit = "N/m", .default_value = 1500, .min = 0, .max = 2000})
        .tunable({"k", "k_max"})
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 4000})
        .info();
  }
  [[nodiscard]] std::string refuses(const Params& params) const { return params.k == 666 ? "666 is no stiffness" : ""; }
  void tune(const Params& params) { params_ = params; }
  void step(StepContext& context) override { out.send(context.now(), {{params_.k, 0, 0}, {}}); }
  Output<Wrench> out;

 private:
  Params params_;
};

/// Its step takes 300 ms, and begins with the k that it has by then.
class Slow final : public Node {
 public:
  struct Params {
    double k = 0;
    double rate = 0;
  };
  Slow(const Params& params, const NodeContext&) : k_(params.k) {}
  static NodeInfo declare() {
    return Declare<Slow>("sample.slow", "Takes long.")
        .real("k", &Slow::Params::k, {.doc = "what it has", .unit = "N/m", .default_value = 500, .min = 0, .max = 2000})
        .tunable({"k"})
        .rate("rate", &Slow::Params::rate, {.doc = "rate", .default_value = 3})
        .sink()
        .info();
  }
  void tune(const Params& params) { k_ = params.k; }
  void step(StepContext&) override {
    const double k = k_;
    begun.fetch_add(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    if (k == 500) old_ended = MonotonicClock::now();
  }
  std::atomic<int> begun{0};
  Instant old_ended;  // the newest step with the first k

 private:
  double k_;
};

/// While a step of the slow node goes on, it asks to set k there.
class Confirmer final : public Node {
 public:
  struct Params {
    double number = 0;
    double rate = 0;
  };
  Confirmer(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare() {
    return Declare<Confirmer>("sample.confirmer", "Asks.")
        .output("requests", &Confirmer::requests, "what it asks")
        .real("number", &Params::number, {.doc = "set in the place of the value, if not 0", .unit = "N/m"})
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 200})
        .sets([](const Params&) {
          return std::vector<Setting>{{"number", "slow.k", "1200 N/m"}};
        })
        .info();
  }
  void request_done() override {
    ++confirmed;
    confirmed_at = MonotonicClock::now();
  }
  void step(StepContext& context) override {
    if (!std::exchange(asked_, true)) {
      const std::string about = "trial 7, interval 1";
      requests.send(context.now(),
                    params_.number == 0 ? set_request(0, about) : number_request(0, params_.number, about));
    }
    if (confirmed == 0) return;
    requests.send(context.now(), end_request());
  }
  Output<SetRequest> requests;
  int confirmed = 0;
  Instant confirmed_at;

 private:
  Params params_;
  bool asked_ = false;
};

struct ConfirmedPlan {
  NodeInfo slow = Slow::declare();
  NodeInfo confirmer = Confirmer::declare();
  Plan plan;
  explicit ConfirmedPlan(Clock clock, double number = 0) {
    plan.graph.duration = Duration::from_seconds(5);
    plan.graph.clock = clock;
    NodeSpec slow_node{"slow", &slow, {500.0, 3.0}, {}, {}, {}};
    slow_node.scheduling.lane = Lane::thread;
    slow_node.scheduling.thread = "slow";
    plan.nodes = {std::move(slow_node), {"confirmer", &confirmer, {number, 200.0}, {}, {}, {}}};
  }
};

/// Asks for `text` at 20.3 ms, and for the end at 50 ms.
class Setter final : public Node {
 public:
  struct Params {
    std::string text;
    double rate = 0;
  };
  Setter(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare() {
    return Declare<Setter>("sample.setter", "Asks.")
        .output("requests", &Setter::requests, "what it asks")
        .text("text", &Params::text, "", "what is to be set")
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 10000})
        .sets([](const Params& params) {
          const std::size_t equals = params.text.find('=');
          return std::vector<Setting>{{"text", params.text.substr(0, equals), params.text.substr(equals + 1)}};
        })
        .info();
  }
  void step(StepContext& context) override {
    if (asked_ == 0 && context.now() >= Time{20'300'000}) {
      ++asked_;
      requests.send(context.now(), set_request(0));
    }
    if (asked_ == 1 && context.now() >= Time{50 * request_ms}) {
      ++asked_;
      requests.send(context.now(), end_request());
    }
  }
  Output<SetRequest> requests;

 private:
  Params params_;
  int asked_ = 0;
};

/// Has a folder to write to, as the table of an experiment.
class Writer final : public Node {
 public:
  struct Params {
    std::string folder;
    double rate = 0;
  };
  Writer(const Params& params, const NodeContext&) : folder(params.folder) {}
  static NodeInfo declare() {
    return Declare<Writer>("sample.writer", "Writes.")
        .text("folder", &Params::folder, "", "where")
        .in_replay("folder", std::string())
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 10})
        .info();
  }
  void step(StepContext&) override {}
  std::string folder;
};

struct AskingPlan {
  NodeInfo sender = Sender::declare();
  NodeInfo setter = Setter::declare();
  NodeInfo keep = Keep::declare();
  Plan plan;

  explicit AskingPlan(Clock clock, const std::string& text = "sender.k=1.2 N/mm") {
    plan.graph.duration = Duration::from_seconds(10);
    plan.graph.clock = clock;
    plan.nodes = {{"sender", &sender, {500.0, 1500.0, 4000.0}, {}, {}, {}},
                  {"setter", &setter, {text, 10000.0}, {}, {}, {}},
                  {"keep", &keep, {}, {}, {}, {}}};
    PlannedEdge edge;
    edge.spec = {"sender", "out", "keep", "in", {QueuePolicy::drop_oldest, 64}, true, {}, {}};
    edge.to = 2;
    edge.triggers = true;
    plan.edges = {edge};
  }
};

/// What was kept of a run whose time is cut into parts of that length.
std::vector<Keep::Entry> kept_in_parts_of(Duration part) {
  AskingPlan asking(Clock::virtual_);
  Session session(asking.plan);
  session.start();
  while (session.is_running()) session.advance(part);
  session.finish();
  return dynamic_cast<const Keep&>(session.nodes()[2]).kept;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_request_holds_from_the_next_millisecond_on_however_time_is_cut) {
  const std::vector<Keep::Entry> whole = kept_in_parts_of(Duration::from_seconds(10));
  // It was asked at 20.3 ms, and asked to end at 50 ms.
  for (const Keep::Entry& entry : whole) BOOST_TEST(entry.value == (entry.now < Time{21 * request_ms} ? 500 : 1200));
  BOOST_REQUIRE(!whole.empty());
  BOOST_TEST((whole.back().now > Time{50 * request_ms}));
  BOOST_TEST((whole.back().now <= Time{51 * request_ms}));
  for (const std::int64_t ns : {100'000LL, 333'333LL, 1'000'000LL, 7'000'001LL}) {
    const std::vector<Keep::Entry> cut = kept_in_parts_of(Duration{ns});
    BOOST_REQUIRE(cut.size() == whole.size());
    for (std::size_t i = 0; i < cut.size(); ++i) {
      BOOST_TEST((cut[i].now == whole[i].now));
      BOOST_TEST(cut[i].value == whole[i].value);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_meter_is_told_of_each_step_of_a_run_whose_nodes_set_each_other_and_changes_nothing) {
  struct Counts final : NodeMeter {
    std::map<std::pair<std::size_t, Work>, std::uint64_t> done;
    std::optional<std::pair<std::size_t, Work>> under_way;
    void begin(std::size_t node, Work work) override {
      BOOST_TEST(!under_way);
      under_way = {node, work};
    }
    void end(std::size_t node, Work work) override {
      BOOST_TEST((under_way == std::pair{node, work}));
      under_way.reset();
      ++done[{node, work}];
    }
  };
  using Work = NodeMeter::Work;
  AskingPlan asking(Clock::virtual_);
  Counts counts;
  Session session(asking.plan, {.engine = {.meter = &counts}});
  session.start();
  while (session.is_running()) session.advance(Duration{request_ms});
  session.finish();
  const std::vector<Keep::Entry> plain = kept_in_parts_of(Duration{request_ms});
  const auto& kept = dynamic_cast<const Keep&>(session.nodes()[2]).kept;
  BOOST_REQUIRE(kept.size() == plain.size());
  for (std::size_t i = 0; i < kept.size(); ++i) BOOST_TEST(kept[i].value == plain[i].value);
  BOOST_TEST(kept.back().value == 1200);
  for (std::size_t n = 0; n < asking.plan.nodes.size(); ++n) {
    BOOST_TEST((counts.done[{n, Work::make}]) == 1U);
    BOOST_TEST((counts.done[{n, Work::start}]) == 1U);
    BOOST_TEST((counts.done[{n, Work::step}]) == session.node_statistics(n).steps);
  }
}

BOOST_AUTO_TEST_CASE(a_live_run_does_what_its_nodes_ask, *boost::unit_test::precondition(test::NeedsLive{})) {
  AskingPlan asking(Clock::real);
  Session session(asking.plan);
  std::vector<bool> sets;
  session.on_set(
      [&sets](const Stamp&, const void* value) { sets.push_back(static_cast<const SetEvent*>(value)->length > 0); });
  session.start();
  while (session.is_running()) session.advance(Duration{20 * request_ms});
  session.finish();
  BOOST_TEST(!session.failure().has_value());
  // The setting, and that it is done.
  BOOST_TEST((sets == std::vector<bool>{true, false}));
  const auto& kept = dynamic_cast<const Keep&>(session.nodes()[2]).kept;
  BOOST_REQUIRE(!kept.empty());
  BOOST_TEST(kept.front().value == 500);
  BOOST_TEST(kept.back().value == 1200);
  // By the end that was asked for, not by the duration.
  BOOST_TEST((kept.back().now < Time::from_seconds(9)));
}

BOOST_AUTO_TEST_CASE(what_a_node_could_not_set_is_refused_before_the_run) {
  for (const auto& [text, part] :
       std::vector<std::pair<std::string, std::string>>{{"sender.k=666", "666 is no stiffness"},
                                                        {"sender.q=1", "did you mean \"sender.k\""},
                                                        {"sender.k=-1", "sender.k"},
                                                        {"sender.k=1800", "k is held at k_max"}}) {
    AskingPlan asking(Clock::virtual_, text);
    try {
      const Session session(asking.plan);
      BOOST_ERROR("it was taken: " << text);
    } catch (const InputError& error) {
      const std::string said = error.what();
      BOOST_TEST(said.find("nodes.setter.text") != std::string::npos, said);
      BOOST_TEST(said.find(part) != std::string::npos, said);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_request_waits_until_the_setting_before_it_holds,
                     *boost::unit_test::precondition(test::NeedsLive{})) {
  ConfirmedPlan asking(Clock::real);
  Session session(asking.plan);
  session.start();
  while (session.is_running()) session.advance(Duration{20 * request_ms});
  session.finish();
  BOOST_TEST(!session.failure().has_value());
  const auto& slow = dynamic_cast<const Slow&>(session.nodes()[0]);
  const auto& confirmer = dynamic_cast<const Confirmer&>(session.nodes()[1]);
  BOOST_REQUIRE(confirmer.confirmed == 1);
  // It was asked within the first step of the slow node, which goes on with the old value.
  BOOST_REQUIRE(slow.begun.load() > 0);
  BOOST_REQUIRE(slow.old_ended.ns > 0);
  BOOST_TEST((confirmer.confirmed_at >= slow.old_ended));
}

BOOST_AUTO_TEST_CASE(under_the_virtual_clock_a_confirmation_comes_at_the_same_instant_as_the_setting) {
  ConfirmedPlan asking(Clock::virtual_);
  Session session(asking.plan);
  std::vector<std::pair<Time, std::string>> sets;
  session.on_set([&sets](const Stamp& stamp, const void* value) {
    const auto& event = *static_cast<const SetEvent*>(value);
    sets.emplace_back(stamp.valid,
                      std::string(event.text.begin(), event.text.begin() + static_cast<std::ptrdiff_t>(event.length)));
  });
  session.start();
  session.advance(Duration{3 * request_ms});
  session.finish();
  BOOST_REQUIRE(sets.size() == 2U);
  BOOST_TEST(sets[0].second == "k=1200 N/m");
  // Without a parameter: the request is done.
  BOOST_TEST(sets[1].second.empty());
  BOOST_TEST((sets[0].first == sets[1].first));
}

BOOST_AUTO_TEST_CASE(what_cannot_be_set_ends_the_run_and_says_what_it_was_for) {
  ConfirmedPlan asking(Clock::virtual_, -1);
  Session session(asking.plan);
  session.start();
  BOOST_CHECK_EXCEPTION(session.advance(Duration::from_seconds(1)), RunError, [](const RunError& error) {
    const std::string said = error.what();
    return said.starts_with("trial 7, interval 1: ") && said.find("slow.k=-1 N/m: ") != std::string::npos;
  });
  BOOST_TEST(dynamic_cast<const Confirmer&>(session.nodes()[1]).confirmed == 0);
}

BOOST_AUTO_TEST_CASE(a_setting_that_a_limit_would_change_is_refused_by_a_check_too) {
  const AskingPlan good(Clock::virtual_, "sender.k=1500");
  BOOST_CHECK_NO_THROW(check_nodes(good.plan));
  const AskingPlan limited(Clock::virtual_, "sender.k=1501");
  BOOST_CHECK_EXCEPTION(check_nodes(limited.plan), InputError, [](const InputError& error) {
    return std::string(error.what()).find("nodes.setter.text: sender.k=1501: k is held at k_max") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(a_limit_that_is_set_itself_is_felt_and_refused_by_no_check) {
  const AskingPlan felt(Clock::virtual_, "sender.k_max=100");
  BOOST_CHECK_NO_THROW(check_nodes(felt.plan));
}

BOOST_AUTO_TEST_CASE(a_request_for_a_setting_that_is_not_declared_ends_the_run) {
  NodeInfo other = Setter::declare();
  other.sets = [](const std::vector<ParamValue>&) { return std::vector<Setting>{}; };
  AskingPlan asking(Clock::virtual_);
  asking.plan.nodes[1].info = &other;
  Session session(asking.plan);
  session.start();
  BOOST_CHECK_EXCEPTION(session.advance(Duration::from_seconds(1)), RunError, [](const RunError& error) {
    return std::string(error.what()) == "there is no setting of index 0";
  });
}

BOOST_AUTO_TEST_CASE(a_session_that_keeps_no_tables_says_whose_it_leaves_out) {
  const NodeInfo writer = Writer::declare();
  const auto made = [&writer](const std::string& folder, bool keeps) {
    Plan plan;
    plan.graph.duration = Duration::from_seconds(1);
    plan.graph.clock = Clock::virtual_;
    plan.nodes = {{"writer", &writer, {folder, 10.0}, {}, {}, {}}};
    Session session(plan, {.keeps_tables = keeps});
    return std::pair{dynamic_cast<const Writer&>(session.nodes()[0]).folder, session.nodes().notes()};
  };
  BOOST_TEST(made("out", true).first == "out");
  BOOST_TEST(made("out", true).second.empty());
  const auto [folder, notes] = made("out", false);
  BOOST_TEST(folder.empty());
  BOOST_REQUIRE(notes.size() == 1U);
  BOOST_TEST(notes[0] == "node writer: folder is left empty, because this run writes no tables");
  BOOST_TEST(made("", false).second.empty());
}

BOOST_AUTO_TEST_SUITE_END()
