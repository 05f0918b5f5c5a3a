// What a run reports is known before it, and a study that asks for anything else is refused.
#include "app/run/run_metrics.hpp"

#include <boost/test/unit_test.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "app/run/run.hpp"
#include "app/study/run/study_metrics.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(run_metrics_test)

using namespace tactor;

namespace {

class Beat final : public Node {
 public:
  struct Params {
    double rate = 0;
  };
  Beat(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Beat>("test.beat", "Sends nothing new.")
        .output("out", &Beat::out, "zero")
        .rate("rate", &Params::rate, {.doc = "a second", .default_value = 1000})
        .info();
  }
  void step(StepContext& context) override { out.send(context.now(), {}); }
  Output<Wrench> out;
};

class Meter final : public Node {
 public:
  struct Params {
    bool fine = false;
    bool lies = false;
  };
  Meter(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare() {
    return Declare<Meter>("test.meter", "Measures.")
        .sink()
        .input("in", &Meter::in, {.doc = "what it measures", .trigger = Trigger::yes})
        .input("more", &Meter::more, {.doc = "what it measures beside it", .required = false})
        .boolean("fine", &Params::fine, false, "measure finely")
        .boolean("lies", &Params::lies, false, "report what is not declared")
        .metric("meter.error_N", "N", "error", Better::lower)
        .metric("meter.gain_N", "N", "gain", Better::higher)
        .metric("meter.late_N", "N", "error after a second", Better::lower)
        .missing_where("the run takes less than a second")
        .metric("meter.count", "1", "messages", Better::neither)
        .summed()
        .metric("meter.fine_N", "N", "fine error", Better::lower)
        .left_out_when([](const Params& p, const MetricUse&) { return std::string(p.fine ? "" : "fine is false"); })
        .metric("meter.torque_Nm", "N m", "error of the torque", Better::lower)
        .left_out_when([](const Params&, const MetricUse& use) {
          return std::string(use.torque ? "" : "the scene is translation-only");
        })
        .metric("meter.against_N", "N", "error against the reference", Better::lower)
        .left_out_when([](const Params&, const MetricUse& use) {
          return std::string(use.reference ? "" : "no reference run is made");
        })
        .metric("meter.more_N", "N", "error of more", Better::lower)
        .left_out_when([](const Params&, const MetricUse& use) {
          return std::string(use.is_fed("more") ? "" : "nothing feeds the input more");
        })
        .info();
  }
  void step(StepContext&) override { ++count_; }
  void report(Report& report) const override {
    report.set("meter.error_N", 1);
    report.set("meter.gain_N", 2);
    report.add("meter.count", count_);
    if (params_.fine) report.set("meter.fine_N", 3);
    report.set("meter.against_N", 4);
    if (more.connected()) report.set("meter.more_N", 5);
    if (params_.lies) report.set("meter.what_N", 6);
  }
  Input<Wrench> in;
  Input<Wrench> more;

 private:
  Params params_;
  double count_ = 0;
};

class Rarity final : public Node {
 public:
  struct Params {};
  Rarity(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Rarity>("test.rarity", "Measures what no graph here asks for.")
        .sink()
        .input("in", &Rarity::in, {.doc = "what it measures", .trigger = Trigger::yes})
        .metric("rarity.size_m", "m", "size", Better::lower)
        .info();
  }
  void step(StepContext&) override {}
  Input<Wrench> in;
};

struct Fixture {
  Fixture() {
    registry.add<Beat>();
    registry.add<Meter>();
    registry.add<Rarity>();
  }

  Plan plan(const std::string& meters = "a: {type: test.meter}", const std::string& edges = "beat.out -> a.in") {
    const auto file = folder.path() / "g.yaml";
    std::ofstream(file) << "clock: virtual\nduration: 10 ms\nscene: {bodies: {}}\nnodes: {beat: {type: test.beat}, " +
                               meters + "}\nedges: [" + edges + "]\n";
    return make_plan(load_graph(file, registry));
  }

  std::string refusal(const std::string& text, const Plan& plan) {
    const auto file = folder.path() / "study.yaml";
    std::ofstream(file) << "graphs: [g.yaml]\n" + text;
    const StudySpec spec = load_study(file);
    RunMetrics metrics = run_metrics(plan, !spec.without_reference);
    metrics.add(run_times(plan));
    try {
      check_metrics(spec, metrics, registry);
    } catch (const GraphError& error) {
      return std::string(error.what()).substr(folder.path().string().size() + 1);
    }
    return {};
  }

  TemporaryFolder folder;
  Registry registry{{}};
};

std::vector<std::string> names_of(const RunMetrics& metrics) {
  std::vector<std::string> names;
  for (const auto& [name, info] : metrics.reported) {
    BOOST_TEST(name == info.name);
    names.push_back(name);
  }
  return names;
}

std::vector<std::string> reported(const RunResult& result) {
  std::vector<std::string> names;
  for (const auto& [name, value] : result.metrics) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

namespace tt = boost::test_tools;

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_run_reports_what_was_told_before_it, Fixture) {
  for (const bool second : {false, true}) {
    const Plan made = second ? plan("a: {type: test.meter, fine: true}, b: {type: test.meter}",
                                    "beat.out -> a.in, beat.out -> b.in, beat.out -> b.more")
                             : plan();
    RunOptions options;
    options.cache_folder = folder.path();
    const RunResult result = execute(made, options);
    BOOST_TEST(!result.failure);
    std::vector<std::string> told;
    for (const auto& [name, info] : run_metrics(made, true).reported) {
      // Nothing here has to warm up.
      if (info.missing.empty() || name == "warm_from_s") told.push_back(name);
    }
    BOOST_TEST(reported(result) == told, tt::per_element());
    BOOST_TEST(result.info("meter.error_N")->unit == "N");
    BOOST_TEST((result.info("b.meter.error_N") != nullptr) == second);
  }
}

BOOST_FIXTURE_TEST_CASE(a_second_node_has_its_name_in_front_of_what_it_sets, Fixture) {
  const RunMetrics metrics = run_metrics(plan("a: {type: test.meter, fine: true}, b: {type: test.meter}",
                                              "beat.out -> a.in, beat.out -> b.in, beat.out -> b.more"),
                                         true);
  const std::vector<std::string> expected{
      "b.meter.against_N", "b.meter.error_N",   "b.meter.gain_N", "b.meter.late_N", "drops",        "fallbacks",
      "meter.against_N",   "meter.count",       "meter.error_N",  "meter.fine_N",   "meter.gain_N", "meter.late_N",
      "meter.more_N",      "reference.rate_hz", "refits",         "warm_from_s"};
  BOOST_TEST(names_of(metrics) == expected, tt::per_element());
  BOOST_TEST(metrics.left_out.size() == 1U);
  BOOST_TEST(metrics.left_out.at("meter.torque_Nm") == "the scene is translation-only");
}

BOOST_FIXTURE_TEST_CASE(a_node_that_reports_what_it_does_not_declare_fails_the_run, Fixture) {
  RunOptions options;
  options.cache_folder = folder.path();
  const RunResult result = execute(plan("a: {type: test.meter, lies: true}"), options);
  BOOST_REQUIRE(result.failure.has_value());
  BOOST_TEST(result.failure->starts_with("node a reports the metric meter.what_N, which its type does not declare"));
  // What it reported before is kept, and so is what the program adds.
  BOOST_TEST(result.metric("meter.error_N") == 1);
  BOOST_TEST(result.metric("drops") == 0);
}

BOOST_FIXTURE_TEST_CASE(a_run_in_real_time_reports_its_lanes_too, Fixture) {
  Plan made = plan();
  made.graph.clock = Clock::real;
  made.nodes.front().scheduling.lane = Lane::realtime;
  const RunMetrics metrics = run_metrics(made, true);
  for (const char* name : {"record_drops", "stalled", "device.ticks", "device.wakeup_us.p99_99", "device.body_us.max",
                           "end_to_end_us.p50"}) {
    BOOST_TEST(metrics.reported.contains(name), name);
  }
  BOOST_TEST(!metrics.reported.contains("device.body_us.p99_9"));
  BOOST_TEST(metrics.reported.at("device.wakeup_us.max").unit == "us");
}

BOOST_FIXTURE_TEST_CASE(a_metric_that_a_study_names_must_be_one_that_a_run_reports, Fixture) {
  const Plan made = plan();
  BOOST_TEST(refusal("metrics: [meter.error_N, meter.late_N, drops, cpu_ms_per_s, cost_us.a.median]\n", made) == "");
  BOOST_TEST(refusal("metrics: [drops, meter.eror_N]\n", made) ==
             "study.yaml:2:18: metrics: expected a metric that a run of the study reports, found meter.eror_N; did you "
             "mean \"meter.error_N\"?");
  BOOST_TEST(refusal("metrics: [meter.fine_N]\n", made) ==
             "study.yaml:2:11: metrics: expected a metric that a run of the study reports, found meter.fine_N, which "
             "no run reports: fine is false");
  BOOST_TEST(refusal("metrics: [meter.fine_N]\n", plan("a: {type: test.meter, fine: true}")) == "");
  BOOST_TEST(refusal("metrics: [meter.against_N]\n", made) == "");
  BOOST_TEST(refusal("reference: none\nmetrics: [meter.against_N]\n", made) ==
             "study.yaml:3:11: metrics: expected a metric that a run of the study reports, found meter.against_N, "
             "which no run reports: no reference run is made");
  BOOST_TEST(refusal("metrics: [rarity.size_m]\n", made) ==
             "study.yaml:2:11: metrics: expected a metric that a run of the study reports, found rarity.size_m, which "
             "no run reports: no graph has a node of the type test.rarity");
  BOOST_TEST(refusal("metrics: [method_us_per_tick]\n", made) ==
             "study.yaml:2:11: metrics: expected a metric that a run of the study reports, found method_us_per_tick, "
             "which no run reports: no node of the graph is a device");
  // All of them are told at once.
  const std::string two = refusal("metrics: [meter.eror_N,\n  nothing.like_it]\n", made);
  BOOST_TEST(two.find("study.yaml:2:11: ") != std::string::npos, two);
  BOOST_TEST(two.find("study.yaml:3:3: metrics: expected a metric that a run of the study reports, found "
                      "nothing.like_it") != std::string::npos,
             two);
}

BOOST_FIXTURE_TEST_CASE(a_report_needs_its_metric, Fixture) {
  const Plan made = plan();
  BOOST_TEST(refusal("report: {kind: work_precision, error: meter.error_N}\n", made) == "");
  BOOST_TEST(refusal("report: {kind: work_precision, error: meter.gain_N}\n", made) == "");
  BOOST_TEST(refusal("report: {kind: work_precision, error: meter.eror_N}\n", made)
                 .starts_with("study.yaml:2:39: "
                              "report.error: expected"));
  BOOST_TEST(
      refusal("report: {kind: work_precision, error: meter.count}\n", made) ==
      "study.yaml:2:39: report.error: expected a metric with a direction, found meter.count, for which neither lower "
      "nor higher is better");
  BOOST_TEST(refusal("report: work_precision\n", made)
                 .starts_with("study.yaml:2:9: report: work_precision: expected a metric that a run of the study "
                              "reports, found delivered.force.rms_error_N"));
  BOOST_TEST(refusal("vary: {beat.rate: [1], a.fine: [true]}\nreport: {kind: stability}\n", made)
                 .starts_with("study.yaml:3:16: report: stability: expected a metric that a run of the study reports, "
                              "found stability.verdict"));
}

BOOST_AUTO_TEST_CASE(what_some_runs_report_is_not_left_out_of_all) {
  RunMetrics all, some;
  all.left_out["x"] = "it is off";
  some.reported["x"] = {"x"};
  some.left_out["y"] = "it is off too";
  all.add(some);
  BOOST_TEST(all.reported.contains("x"));
  BOOST_TEST(!all.left_out.contains("x"));
  BOOST_TEST(all.left_out.at("y") == "it is off too");
}

BOOST_AUTO_TEST_CASE(tables_show_units_and_directions) {
  BOOST_TEST(unit_text("1") == "");
  BOOST_TEST(unit_text("N/ms^2") == "N/ms²");
  BOOST_TEST(better_text(Better::neither) == "");
  BOOST_TEST(better_text(Better::higher) == "higher");
  BOOST_TEST(direction_mark(Better::lower) == " ↓");
  BOOST_TEST(direction_mark(Better::neither) == "");
}

BOOST_AUTO_TEST_SUITE_END()
