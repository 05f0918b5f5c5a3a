// What `tactor lean` runs and in which order, on nodes that note when they are made.
#include <boost/test/unit_test.hpp>
#include <fstream>
#include <span>
#include <vector>

#include "app/lean/lean.hpp"
#include "app/lean/lean_moves.hpp"
#include "app/run/timed_run.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/declare.hpp"

BOOST_AUTO_TEST_SUITE(lean_measure_test)

using namespace tactor;

namespace {

/// The rounds of every worker that was made, in the order in which they were.
std::vector<double> made;

/// Computes for a while and sends the result, which is always within the budget.
class Worker final : public Node {
 public:
  struct Params {
    double rate = 0, rounds = 0;
  };
  Worker(const Params& params, const NodeContext&) : rounds_(params.rounds) { made.push_back(rounds_); }
  static NodeInfo declare() {
    return Declare<Worker>("test.worker", "Works.")
        .output("out", &Worker::out, "")
        .rate("rate", &Params::rate, {.doc = "steps", .default_value = 1000})
        .real("rounds", &Params::rounds, {.doc = "of the computation", .default_value = 1e5, .min = 0})
        .coarser("rounds", {1e3, 1e1})
        .info();
  }
  void step(StepContext& context) override {
    double x = 0.5;
    for (double i = 0; i < rounds_; ++i) x = 3.9 * x * (1 - x);
    out.send(context.now(), {{x, 0, 0}, {}});
  }
  Output<Wrench> out;

 private:
  double rounds_;
};

class Judge final : public Node {
 public:
  struct Params {};
  Judge(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Judge>("test.judge", "Finds no error.")
        .sink()
        .input("in", &Judge::in, {.trigger = Trigger::yes})
        .metric("delivered.force.rms_error_N", "N", "none", Better::lower)
        .metric("delivered.force.max_error_N", "N", "none", Better::lower)
        .info();
  }
  void step(StepContext&) override {}
  void report(Report& report) const override {
    report.set("delivered.force.rms_error_N", 0);
    report.set("delivered.force.max_error_N", 0);
  }
  Input<Wrench> in;
};

struct Fixture {
  Fixture() {
    registry.add<Worker>();
    registry.add<Judge>();
    const auto file = folder.path() / "graph.yaml";
    std::ofstream(file) << "clock: virtual\nduration: 10 ms\nscene: {bodies: {}}\n"
                           "nodes: {worker: {type: test.worker}, judge: {type: test.judge}}\n"
                           "edges: [worker.out -> judge.in]\n";
    graph = make_plan(load_graph(file, registry)).graph;
    options.budget = 1;
    options.measure.cache_folder = folder.path();
    made.clear();
  }
  TemporaryFolder folder;
  Registry registry{{}};
  GraphSpec graph;
  LeanOptions options;
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(the_check_runs_original_and_result_by_turns_after_a_run_of_each_that_does_not_count, Fixture) {
  options.measure.repeats = warmed_up(4);
  const Lean lean = make_lean(graph, registry, options);
  BOOST_TEST(lean.path.steps.size() >= 1U);
  // A tenth of a second's work against a ten-thousandth: no noise hides that.
  BOOST_TEST(std::get<double>(lean.graph.nodes.front().params[1]) < 1e5);
  const double result = std::get<double>(lean.graph.nodes.front().params[1]);
  BOOST_TEST_REQUIRE(made.size() > 12U);
  // The seed of the check is new, so that its reference takes a run of the original first.
  std::vector<double> expected{1e5, 1e5, result};
  for (int turn = 0; turn < 4; ++turn) expected.insert(expected.end(), {1e5, result});
  BOOST_TEST(std::span(made).last(expected.size()) == expected, boost::test_tools::per_element());
  BOOST_TEST(lean.original_checked.repeats.size() == 4U);
  BOOST_TEST(lean.lean_checked.repeats.size() == 4U);
  BOOST_TEST(lean.ratios().size() == 4U);
  BOOST_TEST(lean.check_timing.repeats.count == 4);
  BOOST_TEST(lean.check_timing.control_us > 0);
}

BOOST_FIXTURE_TEST_CASE(a_move_is_timed_by_turns_with_what_it_came_from, Fixture) {
  LeanMeasureOptions measure = options.measure;
  measure.repeats = warmed_up(3);
  GraphSpec after = graph;
  after.nodes.front().params[1] = 1e1;
  const std::vector<std::uint64_t> seeds{1};
  LeanMeasure twice(graph, measure);
  static_cast<void>(twice.first_look(graph, seeds));
  made.clear();
  const LeanPair pair = twice.compare(graph, after, true, seeds, {.error = 1});
  BOOST_TEST(made == (std::vector<double>{1e1, 1e5, 1e5, 1e1, 1e5, 1e1, 1e5, 1e1}), boost::test_tools::per_element());
  BOOST_TEST(pair.savings().size() == 3U);
  // What costs far more is not looked at again.
  made.clear();
  BOOST_TEST(twice.compare(after, graph, true, seeds, {.error = 1}).after.repeats.empty());
  BOOST_TEST(made == (std::vector<double>{1e5, 1e1}), boost::test_tools::per_element());
  // Unless it is taken in any case.
  BOOST_TEST(twice.compare(after, graph, false, seeds, {.error = 1}).after.repeats.size() == 3U);
}

BOOST_FIXTURE_TEST_CASE(a_small_saving_is_told_with_digits_that_show_it, Fixture) {
  options.measure.repeats = warmed_up(1);
  Lean lean = make_lean(graph, registry, options);
  lean.original_checked.repeats.clear();
  lean.lean_checked.repeats.clear();
  lean.lean_checked.cost = 100;
  for (const auto& [cost, text] : {std::pair{103.6, "1.04 times cheaper"}, {2460.0, "24.6 times cheaper"}}) {
    lean.original_checked.cost = cost;
    BOOST_TEST(lean_table(lean, 80).find(text) != std::string::npos, lean_table(lean, 80));
  }
}

BOOST_FIXTURE_TEST_CASE(a_graph_that_is_lean_already_is_told_as_such_and_not_as_a_result, Fixture) {
  graph.nodes.front().params[1] = 1e1;
  options.measure.repeats = warmed_up(1);
  const Lean lean = make_lean(graph, registry, options);
  BOOST_TEST(lean.path.steps.empty());
  for (const std::string& text : {lean_table(lean, 80), lean_markdown(lean)}) {
    BOOST_TEST(text.find("no cheaper graph was found") != std::string::npos, text);
    BOOST_TEST(text.find("times cheaper") == std::string::npos, text);
  }
}

BOOST_FIXTURE_TEST_CASE(what_is_left_out_or_not_read_is_not_tried, Fixture) {
  const auto tried = [this](const GraphSpec& of) {
    std::vector<std::string> names;
    for (const auto& move : lean_moves(of, registry)) names.push_back(move.group);
    return names;
  };
  BOOST_TEST(tried(graph) == (std::vector<std::string>{"worker.rounds", "worker.rounds"}),
             boost::test_tools::per_element());
  // A second worker that nobody reads is left out of the plan.
  GraphSpec with_idle = graph;
  with_idle.nodes.push_back(with_idle.nodes.front());
  with_idle.nodes.back().name = "idle";
  BOOST_TEST(tried(with_idle) == tried(graph), boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(a_body_that_deforms_is_tried_with_fewer_tetrahedra_unless_its_cell_size_counts, Fixture) {
  const auto tried = [this] {
    std::vector<std::string> names;
    for (const auto& move : lean_moves(graph, registry)) names.push_back(move.what);
    return names;
  };
  const std::vector<std::string> without = tried();
  Body gel{.name = "gel", .motion = Motion::deformable};
  gel.deformable.tetrahedra = 1000;
  graph.scene.bodies.push_back(gel);
  std::vector<std::string> expected{"tetrahedra of gel: 1000 -> 500", "tetrahedra of gel: 1000 -> 250"};
  expected.insert(expected.end(), without.begin(), without.end());
  BOOST_TEST(tried() == expected, boost::test_tools::per_element());
  graph.scene.bodies.back().deformable.cell_size = 0.01;
  BOOST_TEST(tried() == without, boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(a_run_that_is_interrupted_ends_there, Fixture) {
  options.measure.interrupted = [] { return true; };
  BOOST_CHECK_THROW(make_lean(graph, registry, options), Interrupted);
}

BOOST_AUTO_TEST_SUITE_END()
