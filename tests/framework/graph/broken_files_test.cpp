// Files that nobody meant: noise, bombs, deep nesting, mutations. A load throws GraphError or gives a graph.
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <fstream>
#include <sstream>

#include "framework/graph/plan.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(broken_files_test)

using namespace tactor;
using namespace tactor::testing;
namespace fs = std::filesystem;

namespace {

struct Dice {
  boost::random::mt19937_64 engine{11};
  std::size_t operator()(std::size_t below) {
    return boost::random::uniform_int_distribution<std::size_t>(0, below - 1)(engine);
  }
};

std::string noise(Dice& draw, std::size_t size, const std::string& letters) {
  std::string text(size, ' ');
  for (char& c : text) c = letters[draw(letters.size())];
  return text;
}

std::string all_bytes() {
  std::string text;
  for (int i = 0; i < 256; ++i) text += static_cast<char>(i);
  return text;
}

// True where the text is a graph; every other end than a GraphError is a failure of the test.
bool loads(const Folder& folder, const std::string& text) {
  try {
    const Plan plan = make_plan(load_text(folder, text));
    static_cast<void>(make_reference_plan(plan));
    static_cast<void>(explain(plan));
    return true;
  } catch (const GraphError& e) {
    BOOST_TEST(!e.diagnostics().empty());
    return false;
  }
}

// Text with the number in the place of each #.
std::string numbered(const std::string& text, int number) {
  std::string result;
  for (const char c : text) {
    if (c == '#') {
      result.append(std::to_string(number));
    } else {
      result.push_back(c);
    }
  }
  return result;
}

std::string repeated(const std::string& text, std::size_t times) {
  std::string result;
  for (std::size_t i = 0; i < times; ++i) result += text;
  return result;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

BOOST_AUTO_TEST_CASE(ten_megabytes_are_refused_whatever_they_hold) {
  const Folder folder;
  Dice draw;
  BOOST_TEST(contains(errors_of(folder, noise(draw, 10'000'000, all_bytes())), "expected at most 1048576 bytes"));
  BOOST_TEST(contains(errors_of(folder, std::string(1'048'577, ' ')), "found a larger file"));
}

BOOST_AUTO_TEST_CASE(noise_is_refused) {
  const Folder folder;
  Dice draw;
  for (const std::string& letters : {all_bytes(), std::string("[]{}:,- \n\"'#&*!|>?%@`~ab1")}) {
    for (const std::size_t size : {1, 10, 100, 1000, 100'000, 1'000'000}) {
      for (int i = 0; i < (size < 10'000 ? 300 : 2); ++i) BOOST_TEST(!loads(folder, noise(draw, size, letters)));
    }
  }
}

BOOST_AUTO_TEST_CASE(zero_bytes_and_other_encodings_are_refused_with_their_place) {
  const Folder folder;
  BOOST_TEST(contains(errors_of(folder, std::string("duration: 1\nno\0des: 3", 21)),
                      ":2:3: expected text, found the control character 0"));
  BOOST_TEST(contains(errors_of(folder, "title: \xff\xfe\n"), ":1:8: expected text in UTF-8"));
  BOOST_TEST(contains(errors_of(folder, "title: \xc0\xaf\n"), ":1:8: expected text in UTF-8"));
  BOOST_TEST(contains(errors_of(folder, "title: \xed\xa0\x80\n"), ":1:8: expected text in UTF-8"));
  BOOST_TEST(contains(errors_of(folder, "title: \xe2\x82"), ":1:8: expected text in UTF-8"));
  const std::string good =
      "\xef\xbb\xbf"
      "duration: 1 s\r\ntitle: \xe2\x82\xac\r\nnodes: {v: {type: test.values}}\r\n";
  BOOST_TEST(errors_of(folder, good) == "");
}

BOOST_AUTO_TEST_CASE(aliases_do_not_grow_beyond_the_bound) {
  const Folder folder;
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    bomb += numbered("a#: &a# ", i);
    bomb += numbered("[*a#, *a#, *a#, *a#, *a#, *a#, *a#, *a#, *a#, *a#]\n", i - 1);
  }
  BOOST_TEST(contains(errors_of(folder, bomb), "expected at most 100000 values with aliases expanded"));
  std::string chain = "a0: &a0 [x]\n";
  for (int i = 1; i < 5000; ++i) {
    chain += numbered("a#: &a# ", i);
    chain += numbered("[*a#]\n", i - 1);
  }
  BOOST_TEST(contains(errors_of(folder, chain), "expected at most 64 levels of nesting"));
}

BOOST_AUTO_TEST_CASE(nesting_is_bounded_in_every_form) {
  const Folder folder;
  for (const std::string open :
       {"[", "{a: ", "- ", "? ", "[a: ", "{? ", "[[], ", "{[", "!x [", "&a [", "a: [", "\"a\": {"}) {
    for (const std::size_t depth : {60, 100, 1000, 100'000}) BOOST_TEST(!loads(folder, repeated(open, depth)));
  }
  std::string stairs;
  for (std::size_t i = 0; i < 1000; ++i) stairs += std::string(i, ' ') + "a:\n";
  BOOST_TEST(contains(errors_of(folder, stairs), "expected at most 64 levels of nesting"));
  BOOST_TEST(contains(errors_of(folder, "duration: 1\nnodes: " + repeated("[", 65) + repeated("]", 65)), "64 levels"));
}

BOOST_AUTO_TEST_CASE(large_files_within_the_bounds_are_read) {
  const Folder folder;
  std::string many = "duration: 1 s\nnodes:\n";
  for (int i = 0; i < 1900; ++i) many += numbered("  n#: {type: test.values}\n", i);
  BOOST_TEST(loads(folder, many));
  std::string keys = "duration: 1 s\nnodes:\n";
  for (int i = 0; i < 2100; ++i) keys += numbered("  n#: {type: test.values}\n", i);
  BOOST_TEST(contains(errors_of(folder, keys), "expected at most 2000 keys in a map"));
  std::string rows = "duration: 1 s\nnodes:\n  v:\n    type: test.values\n    rows:\n";
  for (int i = 0; i < 30000; ++i) rows += numbered("      - [#, 1]\n", i);
  BOOST_TEST(loads(folder, rows));
}

BOOST_AUTO_TEST_CASE(a_long_chain_of_nodes_is_ordered_without_deep_recursion) {
  const Folder folder;
  std::string nodes = "duration: 1 s\nnodes:\n  device: {type: test.device}\n  judge: {type: test.judge}\n";
  std::string edges = "edges:\n  - device.commanded -> n0.in\n  - n1899.out -> judge.commanded\n";
  for (int i = 0; i < 1900; ++i) {
    nodes += numbered("  n#: {type: test.gate}\n", i);
    if (i == 0) continue;
    edges += numbered("  - n#.out", i - 1);
    edges += numbered(" -> n#.in\n", i);
  }
  BOOST_TEST(loads(folder, nodes + edges));
}

BOOST_AUTO_TEST_CASE(mutations_of_a_good_graph_load_or_are_refused) {
  const Folder folder;
  std::ifstream stream(fs::path(TACTOR_SOURCE_DIR) / "tests/framework/graph/good/pipeline.yaml");
  std::stringstream whole;
  whole << stream.rdbuf();
  const std::string good = whole.str();
  static_cast<void>(folder.write("trace.csv", "0.005\n"));
  BOOST_TEST(loads(folder, good));
  Dice draw;
  const std::string letters = "[]{}:,- \n\"'#&*!|>?%@`~ax019./_\t" + std::string("\xe2\x82\xac\xff\x01", 5);
  int graphs = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string text = good;
    for (std::size_t edits = 1 + draw(4); edits > 0 && !text.empty(); --edits) {
      const std::size_t at = draw(text.size());
      const std::size_t length = 1 + draw(12);
      switch (draw(5)) {
        case 0:
          text[at] = letters[draw(letters.size())];
          break;
        case 1:
          text.erase(at, length);
          break;
        case 2:
          text.insert(at, noise(draw, length, letters));
          break;
        case 3:
          text.insert(draw(text.size()), text.substr(at, 4 * length));
          break;
        default:
          text.erase(at);
          break;
      }
    }
    graphs += loads(folder, text) ? 1 : 0;
  }
  // Some mutations hit a comment or a digit alone.
  BOOST_TEST(graphs > 0);
}

BOOST_AUTO_TEST_SUITE_END()
