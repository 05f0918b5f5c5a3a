// Ranges and designs of a study against their definitions, and what is refused of them.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <set>

#include "app/study/spec/study_spec.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(study_design_test)

using namespace tactor;

namespace {

struct StudyFile {
  TemporaryFolder folder;
  StudyFile() { std::ofstream(folder.path() / "a.yaml") << ""; }
  [[nodiscard]] StudySpec load(const std::string& text, bool use_short = false) const {
    std::ofstream(folder.path() / "study.yaml") << "graphs: [a.yaml]\n" << text;
    return load_study(folder.path() / "study.yaml", use_short);
  }
  [[nodiscard]] std::string error(const std::string& text, bool use_short = false) const {
    try {
      static_cast<void>(load(text, use_short));
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  }
};

std::vector<std::string> texts(const StudyAxis& axis) {
  std::vector<std::string> all;
  for (const StudyValue& value : axis.values) all.push_back(value.text);
  return all;
}

}  // namespace

BOOST_AUTO_TEST_CASE(linear_and_logarithmic_ranges_have_equal_steps_and_equal_ratios) {
  const StudyFile file;
  const StudySpec spec = file.load(
      "vary:\n  x.p: {from: 1 mm, to: 2 mm, count: 5}\n  x.q: {from: 1, to: 1e4, count: 5, scale: log}\n"
      "  x.r: {from: 1, to: 4, count: 9, whole: true}\n");
  const std::vector<std::string> linear{"1 mm", "1.25 mm", "1.5 mm", "1.75 mm", "2 mm"};
  const std::vector<std::string> log{"1", "10", "100", "1000", "10000"};
  const std::vector<std::string> whole{"1", "2", "3", "4"};
  BOOST_TEST(texts(spec.vary[0]) == linear, boost::test_tools::per_element());
  BOOST_TEST(texts(spec.vary[1]) == log, boost::test_tools::per_element());
  BOOST_TEST(texts(spec.vary[2]) == whole, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(one_at_a_time_changes_one_value_from_the_first_of_each) {
  const StudyFile file;
  const StudySpec spec = file.load("vary: {x.p: [1, 2, 3], x.q: [7, 8]}\ndesign: one_at_a_time\n");
  std::vector<std::string> found;
  for (const StudyPoint& point : study_points(spec)) found.push_back(point.values[0].text + point.values[1].text);
  const std::vector<std::string> expected{"17", "27", "37", "18"};
  BOOST_TEST(found == expected, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(a_latin_hypercube_meets_every_slice_of_every_axis_once) {
  const StudyFile file;
  const std::string text =
      "vary:\n  x.p: {from: 0, to: 1, count: 2}\n  x.q: {from: 1, to: 1e6, count: 2, scale: log}\n"
      "  x.r: [a, b, c, d]\ndesign: {latin_hypercube: {samples: 40, seed: 3}}\n";
  const StudySpec spec = file.load(text);
  const std::vector<StudyPoint> points = study_points(spec);
  BOOST_REQUIRE(points.size() == 40U);
  std::set<int> slices_p, slices_q;
  std::map<std::string, int> of_list;
  for (const StudyPoint& point : points) {
    slices_p.insert(static_cast<int>(std::floor(40 * std::stod(point.values[0].text))));
    slices_q.insert(static_cast<int>(std::floor(40 * std::log10(std::stod(point.values[1].text)) / 6)));
    ++of_list[point.values[2].text];
  }
  BOOST_TEST(slices_p.size() == 40U);
  BOOST_TEST(slices_q.size() == 40U);
  for (const auto& [value, count] : of_list) BOOST_TEST(count == 10, value);
  // The same seed draws the same, another does not; and the axes are not drawn alike.
  const std::vector<StudyPoint> again = study_points(file.load(text));
  BOOST_TEST(again[7].values[0].text == points[7].values[0].text);
  StudySpec other = spec;
  other.design_seed = 4;
  BOOST_TEST(study_points(other)[7].values[0].text != points[7].values[0].text);
}

BOOST_AUTO_TEST_CASE(short_settings_lie_over_the_rest) {
  const StudyFile file;
  const std::string text =
      "seeds: 20\nduration: 9 s\nvary: {x.p: [1, 2, 3], x.q: [4, 5]}\nshort: {seeds: 2, duration: 1 s, vary: {x.p: "
      "[1]}}\n";
  BOOST_TEST(study_points(file.load(text)).size() == 6U);
  const StudySpec brief = file.load(text, true);
  BOOST_TEST(brief.seeds == 2);
  BOOST_TEST(brief.duration.value().assignment()->value == "1 s");
  BOOST_TEST(study_points(brief).size() == 2U);
  BOOST_TEST(file.error("seeds: 2\n", true).find("expected the key short, which --short asks for") !=
             std::string::npos);
  BOOST_TEST(file.error("short: {seeds: 0}\n").find("2:16: seeds: expected a whole number from 1") !=
             std::string::npos);
  BOOST_TEST(file.error("short: {short: {}}\n").find("2:9: short.short: expected a key of a study") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(nodes_are_swapped_by_files_and_by_maps) {
  const StudyFile file;
  const StudySpec spec = file.load(
      "methods: [a.yaml, {inline: {nodes: {x: {type: y.z}}}}]\nvary: {way: {swap: {one: a.yaml, two: {nodes: {x: "
      "~}}}}}\n");
  BOOST_REQUIRE(spec.methods.size() == 2U);
  BOOST_TEST(spec.methods[0].name == "a");
  BOOST_TEST(spec.methods[1].name == "inline");
  BOOST_TEST(std::get<Tree>(spec.methods[1].patch.change).value("nodes") != nullptr);
  BOOST_REQUIRE(spec.vary.size() == 1U);
  BOOST_TEST(spec.vary[0].swaps());
  BOOST_TEST(spec.vary[0].values[1].text == "two");
  BOOST_TEST(std::holds_alternative<Tree>(spec.vary[0].values[1].swap.value().change));
}

BOOST_AUTO_TEST_CASE(bad_ranges_designs_and_reports_are_refused_with_their_place) {
  const StudyFile file;
  const auto refused = [&](const std::string& text, const std::string& message) {
    const std::string found = file.error(text);
    BOOST_TEST(found.find(message) != std::string::npos, message << " in " << found);
  };
  refused("vary: {x.p: []}\n",
          "2:13: vary.x.p: expected a list of values, a range {from, to, count} or {swap}, found an empty list");
  refused("vary: {x.p: {from: 2, to: 1, count: 3}}\n",
          "2:27: vary.x.p.to: expected more than `from` (2), found 1: the range is empty");
  refused("vary: {x.p: {from: -1, to: 1, count: 3, scale: log}}\n",
          "2:20: vary.x.p.from: expected a number above 0, found -1: a logarithmic");
  refused("vary: {x.p: {from: 0, to: 1, count: 3, scale: log}}\n", "or go through, 0");
  refused("vary: {x.p: {from: 1 mm, to: 2 m, count: 3}}\n", "expected the unit of `from` (mm), found m");
  refused("vary: {x.p: {from: 1 mn, to: 2 mn, count: 3}}\n", "vary.x.p.from: expected a number with or without unit");
  refused("vary: {x.p: {from: a, to: 2, count: 3}}\n", "vary.x.p.from: expected a number with or without unit");
  refused("vary: {x.p: {from: 1, to: 2, count: 1}}\n", "vary.x.p.count: expected a whole number from 2");
  refused("vary: {x.p: {from: 1, to: 2}}\n", "expected the key count, found none");
  refused("vary: {x.p: {from: 1, to: 2, cuont: 3}}\n", "found an unknown one; did you mean \"count\"?");
  refused("vary: {x.p: [1]}\ndesign: {grid: {}, latin_hypercube: {samples: 3}}\n",
          "3:9: design: expected one of grid, one_at_a_time, latin_hypercube, found grid, latin_hypercube together");
  refused("vary: {x.p: [1]}\ndesign: {latin_hypercube: {}}\n", "expected the key samples");
  refused("vary: {x.p: [1]}\ndesign: latin_hypercube\n", "expected latin_hypercube: {samples: N}");
  refused("vary: {x.p: [1]}\ndesign: gird\n", "did you mean \"grid\"?");
  refused("design: {latin_hypercube: {samples: 3}}\n", "expected parameters under `vary` to sample");
  refused("vary: {seed: {swap: {a: {x.p: 1}}}}\n", "vary.seed: expected a name of your own for the swap; `seed` is a");
  refused("report: pie\n", "report: expected one of table, work_precision, stability");
  refused("report: stability\nvary: {x.p: [1]}\n",
          "expected two parameters under `vary`, the axes of the map, found 1");
  refused("report: stability\nvary: {x.p: [1], x.q: [2]}\ndesign: one_at_a_time\n",
          "a map of stability needs every cell");
  refused("report: {kind: table, worst: 3}\n", "report.worst: expected with kind: stability alone");
  refused("timing: {repeats: 0}\n", "timing.repeats: expected a whole number from 1");
  refused("reference: other\n", "reference: expected one of own");
  refused("duration: 3 s\nset: {duration: 2 s}\n", "duration: named in `set` or `vary` too");
  refused("methods: [{inline: {extends: a.yaml}}]\n", "expected no such key in a map that is laid over a graph");
  refused("vary: {way: {swap: {}}}\n", "expected a map of names to what is laid over the graph, found an empty map");
  refused("metrics: [a, a]\n", "expected different names, found a again");
}

BOOST_AUTO_TEST_SUITE_END()
