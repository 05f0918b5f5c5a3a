// Every shipped graph is run for a while, and reports what it says that it will.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <set>
#include <string>

#include "app/run/run_metrics.hpp"
#include "tests/graphs/every_shipped.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(every_graph_test, *boost::unit_test::precondition(tactor::test::NeedsMeshes{}))

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

std::set<std::string> reported(const RunResult& result) {
  std::set<std::string> names;
  for (const auto& [name, value] : result.metrics) names.insert(name);
  return names;
}

/// Of the metrics told before a run, those are reported that no event in it decides. (Of others than these that a run
/// reports, the run itself fails.)
void check_metrics(const RunResult& result, const fs::path& graph) {
  const std::set<std::string> names = reported(result);
  std::size_t told = 0;
  for (const auto& [name, metric] : run_metrics(planned(graph), true).reported) {
    if (!metric.missing.empty()) continue;
    ++told;
    BOOST_TEST(names.contains(name), name);
  }
  BOOST_TEST(told > 5U);
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_graph_runs) {
  with_each(graphs_with_clock(Clock::virtual_), [](const fs::path& graph) {
    // Past the settling time of the metrics, so that every metric is there.
    const Plan plan = planned(graph, with_few_tetrahedra(graph, {"duration=0.6 s"}));
    RunResult result = run_for_page(plan);
    const std::set<std::string> names = reported(result);
    const auto delivered = names.lower_bound("delivered.");
    if (delivered == names.end() || !delivered->starts_with("delivered.")) {
      // A refit was warm just before the end, which left nothing to judge until the metrics have settled, 0.2 s.
      BOOST_TEST(result.metric("warm_from_s") + 0.2 > 0.6);
      result = run_for_page(planned(graph, with_few_tetrahedra(graph, {"duration=1.2 s"})));
    }
    BOOST_TEST(std::isfinite(result.metric("delivered.force.rms_error_N")));
    BOOST_TEST(result.metric("drops") == 0);
    check_metrics(result, graph);
    check_told(result, plan.graph);
  });
}

BOOST_AUTO_TEST_SUITE_END()
