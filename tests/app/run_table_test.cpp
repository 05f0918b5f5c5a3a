// The table of runs keeps what it is given, and refuses what is not its own.
#include "app/study/table/run_table.hpp"

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <csignal>
#include <limits>

#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(run_table_test)

using namespace tactor;

namespace {

const TableIdentity identity{"t", "study", "options", "program"};
const std::vector<RunName> names{{"duck", "a=1", 3, "x"}, {"duck", "a=2", 3, "y"}};

RunRecord record(std::size_t number) {
  RunRecord r;
  r.number = number;
  r.cpu_s = {0.5, 0.25};
  r.control_us = 1000;
  r.result.title = "a duck";
  r.result.duration_s = 2;
  r.result.cpu_s = 0.375;
  r.result.metrics = {{"z.last_N", 0.1}, {"a.first", std::numeric_limits<double>::quiet_NaN()}, {"inf", INFINITY}};
  r.result.nodes = {{"device", "device.simulated", Role::device, 2000, 1, 0.5, 0.75, 0.001}};
  r.result.declared.emplace("z.last_N", MetricInfo{"z.last_N", "N", "the last", Better::lower});
  r.result.series = {{"one_step_error", "N", {0, 1}, {0.25, -0.5}}};
  r.result.chosen = {{"collision", "collision.auto", "collision.sdf", "it is a mesh"}};
  r.result.left_out = {{"torque", "nothing turns"}};
  r.result.reference.too_coarse = "node slow steps at 60 Hz in both";
  r.result.devices = 1;
  r.result.no_force = {{"device", NoForceReason::dead_man, 200, 200, "button 1 was never held"}};
  return r;
}

std::string refusal(const std::filesystem::path& file, TableMode mode, const TableIdentity& id,
                    const std::vector<RunName>& runs) {
  try {
    const RunTable table(file, mode, id, runs);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

BOOST_AUTO_TEST_CASE(runs_are_read_as_they_were_added) {
  const TemporaryFolder folder;
  RunTable table(folder.path() / "t.sqlite", TableMode::create, identity, names);
  table.add(record(1));
  RunRecord failed;
  failed.number = 0;
  failed.status = RunStatus::failed;
  failed.message = "it broke, 'on purpose'";
  table.add(failed);
  const std::vector<RunRecord> found = table.read();
  BOOST_REQUIRE(found.size() == 2U);
  BOOST_CHECK(found[0].status == RunStatus::failed);
  BOOST_TEST(found[0].message == "it broke, 'on purpose'");
  // It left no time of the fixed computation, which is not a time of 0.
  BOOST_TEST(std::isnan(found[0].control_us));
  const RunRecord& whole = found[1];
  BOOST_CHECK(whole.status == RunStatus::done);
  BOOST_TEST(whole.result.graph == "duck");
  BOOST_TEST(whole.result.seed == 3U);
  BOOST_TEST(whole.cpu_s == record(1).cpu_s, boost::test_tools::per_element());
  BOOST_TEST(whole.control_us == 1000);
  BOOST_TEST(whole.result.metrics[0].first == "z.last_N");
  BOOST_TEST(whole.result.metrics[0].second == 0.1);
  BOOST_TEST(std::isnan(whole.result.metrics[1].second));
  BOOST_TEST(std::isinf(whole.result.metrics[2].second));
  BOOST_TEST(whole.result.nodes[0].steps == 2000U);
  BOOST_CHECK(whole.result.nodes[0].role == Role::device);
  BOOST_TEST(whole.result.nodes[0].p99_us == 0.75);
  BOOST_TEST(table.declared().size() == 1U);
  BOOST_TEST(table.declared().at("z.last_N").unit == "N");
  BOOST_TEST(table.declared().at("z.last_N").doc == "the last");
  BOOST_CHECK(table.declared().at("z.last_N").better == Better::lower);
  BOOST_TEST(whole.result.series[0].value == record(1).result.series[0].value, boost::test_tools::per_element());
  BOOST_TEST(whole.result.chosen[0].why == "it is a mesh");
  BOOST_TEST(whole.result.left_out[0].what == "torque");
  BOOST_TEST(whole.result.reference.too_coarse == "node slow steps at 60 Hz in both");
  BOOST_TEST(whole.result.force_was_withheld());
  BOOST_CHECK(whole.result.no_force[0].reason == NoForceReason::dead_man);
  BOOST_TEST(whole.result.no_force[0].of == 200U);
  BOOST_TEST(whole.result.no_force[0].text == "button 1 was never held");
}

BOOST_AUTO_TEST_CASE(a_killed_writer_loses_nothing_that_was_added) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.sqlite";
  const pid_t child = fork();
  if (child == 0) {
    RunTable table(file, TableMode::create, identity, names);
    table.add(record(1));
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  BOOST_REQUIRE(WIFSIGNALED(status));
  RunTable table(file, TableMode::resume, identity, names);
  const std::vector<bool> expected{false, true};
  BOOST_CHECK(table.finished() == expected);
  table.add(record(0));
  BOOST_TEST(table.read().size() == 2U);
}

BOOST_AUTO_TEST_CASE(a_run_is_added_once) {
  const TemporaryFolder folder;
  RunTable table(folder.path() / "t.sqlite", TableMode::create, identity, names);
  table.add(record(0));
  BOOST_CHECK_THROW(table.add(record(0)), RunError);
  // What did not go in leaves no trace, and the table goes on.
  table.add(record(1));
  BOOST_TEST(table.read()[0].result.metrics.size() == 3U);
}

BOOST_AUTO_TEST_CASE(another_study_is_refused_with_what_has_changed) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.sqlite";
  { const RunTable table(file, TableMode::create, identity, names); }
  const auto expect = [&](TableMode mode, const TableIdentity& id, const std::vector<RunName>& runs, const char* text) {
    const std::string found = refusal(file, mode, id, runs);
    BOOST_TEST(found.find(text) != std::string::npos, text << " in " << found);
  };
  expect(TableMode::create, identity, names, "--resume continues them, --overwrite starts anew");
  expect(TableMode::resume, identity, names, "no error");
  expect(TableMode::resume, {"t", "other", "options", "program"}, names, "the study has changed since");
  expect(TableMode::resume, {"t", "study", "other", "program"}, names,
         "the options of the command line were different");
  expect(TableMode::resume, {"t", "study", "options", "other"}, names, "the program has changed since");
  expect(TableMode::resume, identity, {names[0], {"duck", "a=2", 3, "z"}},
         "the graph, or a file that it names, has changed since: duck a=2, seed 3");
  expect(TableMode::resume, identity, {names[0]}, "its runs are others");
  expect(TableMode::overwrite, {"t", "other", "options", "program"}, {names[0]}, "no error");
}

BOOST_AUTO_TEST_CASE(two_writers_at_once_are_refused) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.sqlite";
  const RunTable table(file, TableMode::create, identity, names);
  BOOST_TEST(refusal(file, TableMode::resume, identity, names).find("found another tactor writing it") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_file_that_is_no_table_is_refused) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.sqlite";
  sqlite3* db = nullptr;
  sqlite3_open(file.c_str(), &db);
  sqlite3_exec(db, "CREATE TABLE x(y)", nullptr, nullptr, nullptr);
  sqlite3_close(db);
  BOOST_TEST(refusal(file, TableMode::resume, identity, names).find("it holds no runs of a study") !=
             std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
