// Every file of bad/ says in its first lines which errors it has, and a load finds these and no others.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <filesystem>
#include <fstream>

#include "framework/engine/plan_nodes.hpp"
#include "framework/graph/plan.hpp"
#include "nodes/forcefield/grid.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(bad_graphs_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

struct Expected {
  std::string place;  // `line:col`, `file:line:col`, or `-` for the file as a whole
  std::string text;   // $FILE stands for the path of the file itself
};

std::vector<Expected> expectations(const fs::path& file) {
  const std::string mark = "# expect: ";
  std::vector<Expected> result;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line) && line.starts_with(mark);) {
    const std::size_t colon = line.find(": ", mark.size());
    BOOST_REQUIRE(colon != std::string::npos);
    result.push_back({line.substr(mark.size(), colon - mark.size()), line.substr(colon + 2)});
    std::string& text = result.back().text;
    const std::string name = "$FILE";
    if (const auto at = text.find(name); at != std::string::npos) text.replace(at, name.size(), file.string());
  }
  return result;
}

// What a check of the graph says is wrong, each `place: message`: of the plan, or else of the bodies.
std::vector<std::string> errors(const fs::path& file, Registry& registry) {
  try {
    check_nodes(make_plan(load_graph(file, registry)));
  } catch (const GraphError& e) {
    std::vector<std::string> texts;
    for (const Diagnostic& d : e.diagnostics()) texts.push_back(d.place.text() + ": " + d.message);
    return texts;
  } catch (const InputError& e) {
    return {e.what()};
  }
  return {};
}

bool fits(const Expected& expected, const std::string& found, const fs::path& file) {
  const bool other_file = std::count(expected.place.begin(), expected.place.end(), ':') == 2;
  const std::string place = expected.place == "-" ? file.string()
                            : other_file          ? (file.parent_path() / expected.place).string()
                                                  : file.string() + ":" + expected.place;
  return found.starts_with(place + ": ") && found.find(expected.text, place.size()) != std::string::npos;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_bad_graph_has_the_errors_it_names_and_no_others) {
  Registry registry = testing::test_registry();
  registry.add<GridForceField>();
  int files = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(TACTOR_SOURCE_DIR) / "tests/framework/graph/bad")) {
    if (entry.path().extension() != ".yaml") continue;
    ++files;
    const std::vector<Expected> expected = expectations(entry.path());
    std::vector<std::string> found = errors(entry.path(), registry);
    std::string text;
    for (const std::string& error : found) text += "\n  " + error;
    BOOST_TEST_CONTEXT(entry.path().filename().string() << " gives" << text) {
      BOOST_TEST(!expected.empty());
      BOOST_TEST(found.size() == expected.size());
      for (const Expected& e : expected) {
        const auto it =
            std::find_if(found.begin(), found.end(), [&](const auto& error) { return fits(e, error, entry.path()); });
        BOOST_TEST((it != found.end()), "not found: " << e.place << ": " << e.text);
        if (it != found.end()) found.erase(it);
      }
    }
  }
  BOOST_TEST(files >= 150);
}

BOOST_AUTO_TEST_CASE(errors_come_in_the_order_of_the_file_one_to_a_line) {
  const testing::Folder folder;
  const std::string text = testing::errors_of(folder, "nodes: {a: {type: test.values, count: x, flag: 1}}\nseed: -1\n");
  const std::string file = (folder.path() / "graph.yaml").string();
  BOOST_TEST(std::count(text.begin(), text.end(), '\n') == 3);
  BOOST_TEST(
      text.starts_with(file + ":1:1: expected the key duration, found none\n" + file + ":1:39: nodes.a.count: "));
  BOOST_TEST(text.find(file + ":1:48: nodes.a.flag: expected true or false, found 1\n" + file + ":2:7: seed: ") !=
             std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
