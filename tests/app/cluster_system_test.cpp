// Cluster files: what is wrong in one is told with its place, and templates become the words of a command.
#include "app/study/cluster/cluster_system.hpp"

#include <boost/test/unit_test.hpp>
#include <fstream>

#include "app/command_output.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(cluster_system_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

const std::string good = R"(
submit: [submit, "--name={name}", "--after=ok:{after}", "{exclusive}", "{options}", "{script}"]
status: [status, "{jobs}"]
cancel: [cancel, "{jobs}"]
index: INDEX
states: {waiting: [Q, H], running: [R]}
)";

fs::path write(const TemporaryFolder& folder, const std::string& text) {
  const fs::path file = folder.path() / "mine.yaml";
  std::ofstream(file) << text;
  return file;
}

std::string errors_of(const std::string& text) {
  const TemporaryFolder folder;
  try {
    static_cast<void>(load_cluster_system(write(folder, text)));
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string with(std::string text, const std::string& old, const std::string& now) {
  return text.replace(text.find(old), old.size(), now);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_cluster_file_is_read) {
  const TemporaryFolder folder;
  const ClusterSystem system = load_cluster_system(write(folder, good));
  BOOST_TEST(system.title == "mine");
  BOOST_TEST(system.index == "INDEX");
  BOOST_TEST(system.joined_by == ":");
  BOOST_TEST(system.most_tasks_of_file == 1000U);
  BOOST_TEST(system.waiting == (std::vector<std::string>{"Q", "H"}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(shipped_cluster_files_are_good) {
  for (const std::string name : {"slurm", "local"}) {
    const fs::path file = fs::path(TACTOR_SOURCE_DIR) / "app/study/cluster/systems" / (name + ".yaml");
    const ClusterSystem system = load_cluster_system(file);
    BOOST_TEST(!system.submit.empty());
    BOOST_TEST(!system.index.empty());
  }
}

BOOST_AUTO_TEST_CASE(what_is_wrong_in_a_cluster_file_is_told_with_its_place) {
  BOOST_TEST(errors_of(with(good, "submit:", "sumbit:")).find("mine.yaml:2:1: ") != std::string::npos);
  BOOST_TEST(errors_of(with(good, "{name}", "{nmae}")).find("{nmae}; did you mean \"name\"?") != std::string::npos);
  BOOST_TEST(errors_of(with(good, "[cancel, \"{jobs}\"]", "cancel")).find("cancel: expected a list of words") !=
             std::string::npos);
  BOOST_TEST(errors_of(with(good, "[cancel, \"{jobs}\"]", "[]")).find("found an empty list") != std::string::npos);
  BOOST_TEST(errors_of(with(good, "index: INDEX", "")).find("the key index is missing: expected index: the variable") !=
             std::string::npos);
  BOOST_TEST(errors_of(with(good, "cancel: [cancel, \"{jobs}\"]", ""))
                 .find("mine.yaml:2:1: the key cancel is missing: expected cancel: a list of words") !=
             std::string::npos);
  BOOST_TEST(errors_of(with(good, ", running: [R]", "")).find("the key states.running is missing") !=
             std::string::npos);
  BOOST_TEST(errors_of(with(good, "running: [R]", "runing: [R]")).find("did you mean \"running\"?") !=
             std::string::npos);
  BOOST_TEST(errors_of(good + "most_tasks: 0\n").find("most_tasks: ") != std::string::npos);
  BOOST_TEST(errors_of(with(good, "\"{script}\"", "x")).find("submit: expected {script} in a word") !=
             std::string::npos);
  BOOST_TEST(errors_of("- a\n").find("mine.yaml") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(words_without_a_value_are_left_out_and_lists_become_words) {
  TemplateValues values;
  values.texts = {{"name", "a study"}, {"script", "/x y.sh"}, {"exclusive", ""}};
  values.lists = {{"after", {"7", "8"}}, {"options", {"-q", "long one"}}};
  const CommandTemplate command{"submit",
                                "--name={name}",
                                "--after=ok:{after}",
                                "{exclusive}",
                                "--account={account}",
                                "{options}",
                                "{script}",
                                "${name}",
                                "%{",
                                "{After}"};
  const std::vector<std::string> expected{
      "submit", "--name=a study", "--after=ok:7:8", "-q", "long one", "/x y.sh", "${name}", "%{", "{After}"};
  BOOST_TEST(filled_in(command, values, ":") == expected, boost::test_tools::per_element());
  values.lists = {{"after", {}}, {"options", {}}};
  const std::vector<std::string> alone{"submit", "--name=a study", "/x y.sh", "${name}", "%{", "{After}"};
  BOOST_TEST(filled_in(command, values, ":") == alone, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(values_are_quoted_where_a_shell_reads_the_word_and_nowhere_else) {
  const std::string hostile = "a'; touch x";
  TemplateValues values;
  values.texts = {{"name", hostile}};
  values.lists = {{"jobs", {"7", hostile}}};
  const auto words = [&](const CommandTemplate& command) { return filled_in(command, values, ","); };
  const std::string quoted = "'a'\\''; touch x'";
  using Words = std::vector<std::string>;
  const std::vector<std::pair<CommandTemplate, Words>> table{
      {{"sh", "-c", "echo {name}", "{name}"}, {"sh", "-c", "echo " + quoted, hostile}},
      {{"/bin/bash", "-eu", "-c", "{name}"}, {"/bin/bash", "-eu", "-c", quoted}},
      {{"env", "A=1", "dash", "-c", "{jobs}"}, {"env", "A=1", "dash", "-c", "'7'", quoted}},
      {{"sbatch", "--wrap=run {name}"}, {"sbatch", "--wrap=run " + quoted}},
      {{"sbatch", "--wrap", "run {name}"}, {"sbatch", "--wrap", "run " + quoted}},
      {{"ssh", "login", "sbatch", "-J{name}", "{jobs}"}, {"ssh", "login", "sbatch", "-J" + quoted, "'7'", quoted}},
      {{"sbatch", "-c", "{name}", "{jobs}"}, {"sbatch", "-c", hostile, "7", hostile}},
      {{"sbatch", "--job-name={name}"}, {"sbatch", "--job-name=" + hostile}},
  };
  for (const auto& [command, expected] : table)
    BOOST_TEST(words(command) == expected, boost::test_tools::per_element());
  values.texts["name"] = "a\nb";
  BOOST_CHECK_THROW(words({"sh", "-c", "{name}"}), InputError);
  BOOST_TEST(errors_of(with(good, "status: [status,", "status: [sh, -c, \"x {name} | awk '{print $1}'\",")) ==
             "no error");
  for (const std::string place :
       {R"("sh", "-c", "x '{name}'")", R"(sh, -c, 'x "{name}"')", R"(ssh, a, 'x "b {name}"')", R"(sh, -c, 'x \{name}')",
        R"(sh, -c, 'x `y {name}`')", R"(sh, -c, "x <<E\n{name}\nE\n")"}) {
    const std::string said = errors_of(with(good, "status: [status,", "status: [" + place + ","));
    BOOST_TEST(said.find("no quotes round {...}") != std::string::npos, said);
  }
}

BOOST_AUTO_TEST_CASE(the_output_of_a_command_is_read_and_its_failure_told) {
  BOOST_TEST(output_of({"printf", "%s\\n", "a b"}) == "a b\n");
  const auto failure = [](const std::vector<std::string>& words) {
    try {
      static_cast<void>(output_of(words));
    } catch (const RunError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  BOOST_TEST(failure({"sh", "-c", "echo it is full >&2; exit 3"}).ends_with("has failed: it is full"));
  BOOST_TEST(failure({"no_such_program_here"}).find("is it installed here?") != std::string::npos);
  // More than a pipe holds, on both.
  BOOST_TEST(output_of({"sh", "-c", "seq 100000 >&2; seq 100000"}).size() == 588895U);
}

BOOST_AUTO_TEST_CASE(states_of_jobs_are_counted) {
  const TemporaryFolder folder;
  ClusterSystem system = load_cluster_system(write(folder, good));
  system.status = {"printf", "%s\\n", "12 0 R", "12 1 R", "12 2 Q", "13 Q", "14 0 F", "99 0 R"};
  const auto counts = ask_for_jobs(system, {"12", "13", "14"});
  BOOST_TEST(counts.at("12").running == 2U);
  BOOST_TEST(counts.at("12").waiting == 1U);
  BOOST_TEST(counts.at("13").waiting == 1U);
  BOOST_TEST(counts.count("14") == 0U);
  BOOST_TEST(counts.count("99") == 0U);
  system.most_tasks = {"echo", "1001"};
  BOOST_TEST(most_tasks_of_array(system) == 1001U);
  system.most_tasks = {"echo", "many"};
  BOOST_CHECK_THROW(most_tasks_of_array(system), RunError);
}

BOOST_AUTO_TEST_SUITE_END()
