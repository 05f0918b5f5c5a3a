// One order of places for every kind of file that is named, and what is told where none has it.
#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <fstream>

#include "framework/core/temporary_folder.hpp"
#include "framework/yaml/file_finder.hpp"

BOOST_AUTO_TEST_SUITE(file_lookup_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

const FileKind kind{
    .noun = "a tune", .variable = "TACTOR_TEST_PATH", .folder = "no_such_folder", .part = "slow", .ending = ".tune"};

struct Fixture {
  TemporaryFolder folder;
  fs::path beside = folder.path() / "beside", first = folder.path() / "first", second = folder.path() / "second";

  Fixture() {
    for (const char* name : {"a.tune", "plain"}) write(beside / name);
    for (const char* name : {"a.tune", "slow/b.tune", "c.txt", "slow/d.tune/inside"}) write(first / name);
    for (const char* name : {"slow/a.tune", "slow/b.tune", "slow/d.tune"}) write(second / name);
    setenv("TACTOR_TEST_PATH", (first.string() + "::" + second.string() + ":/does/not/exist").c_str(), 1);
  }
  ~Fixture() { unsetenv("TACTOR_TEST_PATH"); }
  Fixture(const Fixture&) = delete;
  Fixture& operator=(const Fixture&) = delete;

  static void write(const fs::path& file) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "la";
  }
  fs::path find(const std::string& name) const { return find_file(name, {beside}, kind).file; }
};

template <class Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

Tree text_at(const std::string& text, const SourceLocation& place) {
  Tree tree;
  tree.kind = Tree::Kind::scalar;
  tree.text = text;
  tree.place = place;
  return tree;
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_file_beside_comes_before_those_of_the_user_and_these_in_their_order, Fixture) {
  BOOST_TEST(find("a.tune") == beside / "a.tune");
  BOOST_TEST(find("slow/a.tune") == second / "slow/a.tune");
  BOOST_TEST(find("b.tune") == first / "slow/b.tune");
  BOOST_TEST(find((second / "slow/b.tune").string()) == second / "slow/b.tune");
  BOOST_TEST(find("../first/c.txt") == first / "c.txt");
  // A folder of that name is passed over.
  BOOST_TEST(find("d.tune") == second / "slow/d.tune");
}

BOOST_FIXTURE_TEST_CASE(the_ending_and_the_part_may_be_left_out_of_the_name_of_a_shared_file_alone, Fixture) {
  BOOST_TEST(find("b") == first / "slow/b.tune");
  BOOST_TEST(find("slow/b") == first / "slow/b.tune");
  // Beside, `a` is no name of a.tune: a file of another kind may have the same name before its ending.
  BOOST_TEST(find("a") == first / "a.tune");
  BOOST_TEST(find("plain") == beside / "plain");
  BOOST_TEST(find("c").empty());
  BOOST_TEST(find("nowhere").empty());
  BOOST_TEST(find("/nowhere/a").empty());
}

BOOST_FIXTURE_TEST_CASE(the_list_of_a_kind_has_each_name_once_as_it_is_found, Fixture) {
  const std::vector<fs::path> expected{first / "slow/b.tune", first / "a.tune", second / "slow/d.tune"};
  const std::vector<fs::path> found = files_of(kind);
  BOOST_TEST_REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) BOOST_TEST(found[i] == expected[i]);
}

BOOST_FIXTURE_TEST_CASE(a_name_without_its_ending_is_found_beside_when_it_is_nowhere_else, Fixture) {
  write(beside / "own.tune");
  write(beside / "b.tune");
  BOOST_TEST(find_file("own", {beside}, kind).file == beside / "own.tune");
  // Nothing that is installed is hidden by it.
  BOOST_TEST(find_file("b", {beside}, kind).file != beside / "b.tune");
  BOOST_TEST(find_file("own.tune", {beside}, kind).file == beside / "own.tune");
}

BOOST_FIXTURE_TEST_CASE(a_kind_without_shared_files_is_looked_for_beside_alone, Fixture) {
  const FileSearch search = find_file("b.tune", {beside}, any_file);
  BOOST_TEST(search.file.empty());
  BOOST_TEST_REQUIRE(search.tried.size() == 1U);
  BOOST_TEST(search.tried[0] == beside / "b.tune");
}

BOOST_FIXTURE_TEST_CASE(where_a_file_is_missing_all_places_and_the_nearest_name_are_told, Fixture) {
  const std::string text = refusal([&] { named_file("slow/bb", kind); });
  BOOST_TEST(
      text.starts_with("slow/bb: expected a tune that exists; looked for " + fs::absolute("slow/bb").string() + ", " +
                       (first / "slow/slow/bb.tune").string() + ", " + (first / "slow/bb.tune").string() + ", "),
      text);
  BOOST_TEST(text.find("/no_such_folder/slow/bb.tune") != std::string::npos, text);
  BOOST_TEST(text.find("; " + (second / "slow").string() + " holds a.tune, b.tune, d.tune") != std::string::npos, text);
  BOOST_TEST(text.ends_with("; did you mean \"b.tune\"?"), text);
  BOOST_TEST(refusal([&] { named_file(first / "slow", any_file); }).find("(a folder)") != std::string::npos);
}

BOOST_FIXTURE_TEST_CASE(what_a_value_names_is_looked_for_beside_its_file_and_beside_the_graph, Fixture) {
  const FileFinder files(first);
  Diagnostics diagnostics;
  const SourceLocation in_beside{(beside / "graph.yaml").string(), 3, 4};
  BOOST_TEST(files.find(text_at("a.tune", in_beside), "x", any_file, diagnostics).value() == beside / "a.tune");
  BOOST_TEST(files.find(text_at("c.txt", in_beside), "x", any_file, diagnostics).value() == first / "c.txt");
  // A value of the command line has no file of its own.
  BOOST_TEST(files.find(text_at("a.tune", {"--set x=a.tune", 0, 0}), "x", any_file, diagnostics).value() ==
             first / "a.tune");
  BOOST_TEST(!diagnostics.any());
  BOOST_TEST(!files.find(text_at("e.tune", in_beside), "x", kind, diagnostics));
  BOOST_TEST(!files.find(text_at("", in_beside), "x", kind, diagnostics));
  BOOST_TEST_REQUIRE(diagnostics.list().size() == 2U);
  BOOST_TEST(diagnostics.list()[0].place.text() == in_beside.text());
  BOOST_TEST(diagnostics.list()[0].message.starts_with(
                 "x: expected a tune that exists, found e.tune; looked for " + (beside / "e.tune").string() + ", " +
                 (first / "e.tune").string() + ", " + (first / "slow/e.tune").string()),
             diagnostics.list()[0].message);
  BOOST_TEST(diagnostics.list()[1].message == "x: expected the path of a tune, found \"\"");
}

BOOST_FIXTURE_TEST_CASE(a_file_name_is_found_in_every_folder_below_the_users_by_the_names_that_it_is_asked_for,
                        Fixture) {
  write(first / "fast/b.tune");
  for (const std::string& name : names_in_folders("b.tune", kind)) BOOST_TEST(!find(name).empty(), name);
  BOOST_TEST(names_in_folders("b.tune", kind) == (std::vector<std::string>{"fast/b", "slow/b"}),
             boost::test_tools::per_element());
  BOOST_TEST(names_in_folders("none.tune", kind).empty());
}

BOOST_AUTO_TEST_SUITE_END()
