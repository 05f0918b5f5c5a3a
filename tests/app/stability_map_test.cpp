// Maps of stability: which cell is the graph's own, what is told of verdicts, and what is refused before anything runs.
#include "app/study/report/stability_map.hpp"

#include <boost/test/unit_test.hpp>
#include <string>
#include <vector>

#include "tests/framework/graph/test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(stability_map_test)

using namespace tactor;

namespace {

constexpr std::size_t wide = 1000;  // columns, so that nothing is folded

/// Two values of a stiffness across, three times of a cost upwards; the graph's own are the first and the second.
struct Map {
  testing::Folder folder;
  Registry registry = testing::test_registry();
  std::vector<RunCase> cases;
  Study study;
  StabilityMaps maps;

  explicit Map(const std::vector<int>& verdicts) {
    static_cast<void>(folder.write("g.yaml", testing::pipeline(testing::sliding_scene)));
    const StudySpec spec = load("report: stability\n");
    cases = study_cases(spec, {});
    std::vector<RunRecord> records(cases.size());
    for (std::size_t i = 0; i < records.size(); ++i) {
      records[i].number = i;
      records[i].result.metrics = {{"stability.verdict", verdicts[i]}};
    }
    study = make_study(spec, make_comparison(cases, {1}, records, {"stability.verdict"}));
    maps = stability_maps(study);
  }

  [[nodiscard]] StudySpec load(const std::string& report) const {
    return load_study(folder.write("study.yaml",
                                   "graphs: [g.yaml]\nvary:\n  coupling.stiffness: [0.8 N/mm, 1 N/mm]\n"
                                   "  collision.cost.base: [5 ms, 6 ms, 7 ms]\nseeds: 1\nreference: none\n" +
                                       report));
  }

  /// Finds the graph's own values and is interrupted at that question, the first being 0. How often it was asked.
  std::size_t find(std::size_t interrupted_at, bool& went_on) {
    std::size_t asked = 0;
    went_on = find_own_values(maps, study, cases, registry, [&] { return asked++ == interrupted_at; });
    return asked;
  }

  [[nodiscard]] std::string record_errors(const std::string& list) {
    try {
      const StudySpec spec = load("report: {kind: stability, record: " + list + "}\n");
      check_record(spec, study_cases(spec, {}), registry);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(the_search_for_the_graphs_own_values_ends_at_any_interrupt) {
  bool went_on = false;
  const std::size_t questions = Map({0, 0, 0, 0, 0, 0}).find(1000, went_on);
  BOOST_TEST(went_on);
  Map whole({0, 0, 0, 0, 0, 0});
  whole.find(1000, went_on);
  BOOST_TEST(whole.maps.maps[0].own_x.value() == 0U);
  BOOST_TEST(whole.maps.maps[0].own_y.value() == 1U);
  // At least once for the map and once for each value that is tried: one across, two upwards.
  BOOST_TEST(questions >= 4U);
  for (std::size_t at = 0; at < questions; ++at) {
    Map map({0, 0, 0, 0, 0, 0});
    BOOST_TEST(map.find(at, went_on) == at + 1);  // nothing is looked into after it
    BOOST_TEST(!went_on);
  }
}

BOOST_AUTO_TEST_CASE(the_key_has_the_verdicts_that_the_map_has) {
  const Map map({0, 0, 3, 0, 1, 0});
  const std::string table = stability_table(map.study, map.maps, wide);
  BOOST_TEST(table.find("s stable, L limit cycle, E energy growth\n") != std::string::npos, table);
  const std::string page = write_stability(map.folder.path(), map.study, map.maps);
  for (const char* text : {"Limit cycle: ", "Energy growth: ", "limit cycle"}) {
    BOOST_TEST(page.find(text) != std::string::npos, text);
  }
  for (const char* text : {"pushed through", "Pushed through", "Not finite", "Refused"}) {
    BOOST_TEST(page.find(text) == std::string::npos, text);
  }
  Map other({2, 0, 0, 0, 0, 0});
  bool went_on = false;
  other.find(1000, went_on);
  BOOST_TEST(
      stability_table(other.study, other.maps, wide).find("s stable, P pushed through; [ ] the graph's own values\n") !=
      std::string::npos);
  BOOST_TEST(write_stability(other.folder.path(), other.study, other.maps).find("Pushed through: ") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(outputs_to_record_are_looked_for_in_the_graphs) {
  Map map({0, 0, 0, 0, 0, 0});
  BOOST_TEST(map.record_errors("[dynamics.state]").empty());
  const std::string errors = map.record_errors("[dynamics.state, dynamics.stat, divice.state, plain, \"it's, x\"]");
  for (const char* text : {"study.yaml:7:52: report.record: dynamics (test.dynamics) has no output stat",
                           "did you mean \"state\"?", "(in g coupling.stiffness=0.8 N/mm collision.cost.base=5 ms)",
                           "study.yaml:7:67: report.record: there is no node \"divice\"", "did you mean \"device\"?",
                           "study.yaml:7:81: report.record: expected node.output, found \"plain\"",
                           "study.yaml:7:88: report.record: expected node.output, found \"it's, x\""}) {
    BOOST_TEST(errors.find(text) != std::string::npos, text << " in " << errors);
  }
}

BOOST_AUTO_TEST_SUITE_END()
