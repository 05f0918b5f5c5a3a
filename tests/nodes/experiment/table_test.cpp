// The table of a participant: what it holds, what it refuses, and what a crash leaves of it.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/experiment/table.hpp"

using namespace tactor;

namespace {

const std::vector<std::string> codes{"A", "B"};

ExperimentRow row_number(int trial) {
  ExperimentRow row;
  row.trial = trial;
  row.run = 1;
  row.block = 1;
  row.condition = row.other = 1;
  row.comparison = 2;
  row.response = 1 + trial % 2;
  row.correct = trial % 2;
  row.level = 0.1 * trial;  // 0.30000000000000004 for 3
  row.response_time = 0.25;
  row.peak_first = 1.5;
  row.peak_second = std::numeric_limits<double>::quiet_NaN();
  return row;
}

std::string text_of_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool names_participant(const ValueError& error) {
  return error.path() == "participant";
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_code_is_letters_and_a_number_and_never_a_name) {
  BOOST_TEST(participant_code("P07").number == 7U);
  BOOST_TEST(participant_code("xy120").number == 120U);
  for (const char* name : {"", "Anna", "Anna Berg", "7", "P", "Annabel1", "P1234567", "P-1", "P1a", "../P1", "P 1"}) {
    BOOST_CHECK_EXCEPTION(static_cast<void>(participant_code(name)), ValueError, names_participant);
  }
}

BOOST_AUTO_TEST_CASE(rows_are_read_back_as_they_were_written) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "study" / "P01.csv";
  {
    TrialTable table = TrialTable::begin(file, codes, 42);
    for (int i = 1; i <= 3; ++i) table.add(row_number(i));
  }
  const TrialTable table = TrialTable::resume(file, codes, 42);
  BOOST_REQUIRE(table.rows().size() == 3U);
  BOOST_TEST(table.rows()[2].level == 0.1 * 3);
  BOOST_TEST(table.rows()[2].response == 2);
  BOOST_TEST(table.rows()[2].condition == 1);
  BOOST_TEST(text_of_file(file).find("3,1,1,B,B,0.30000000000000004,2,2,1,0.25,1.5,,42\n") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_table_that_exists_is_not_written_over) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  TrialTable::begin(file, codes, 42).add(row_number(1));
  const std::string before = text_of_file(file);
  BOOST_CHECK_EXCEPTION(TrialTable::begin(file, codes, 42), ValueError, names_participant);
  BOOST_TEST(text_of_file(file) == before);
}

BOOST_AUTO_TEST_CASE(one_run_at_a_time_writes_a_table) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  const TrialTable first = TrialTable::begin(file, codes, 42);
  BOOST_CHECK_THROW(TrialTable::resume(file, codes, 42), ValueError);
}

BOOST_AUTO_TEST_CASE(a_row_that_was_cut_off_is_taken_away_and_the_others_stay) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  {
    TrialTable table = TrialTable::begin(file, codes, 42);
    for (int i = 1; i <= 3; ++i) table.add(row_number(i));
  }
  const std::string whole = text_of_file(file);
  const std::size_t header = whole.find('\n') + 1;
  // Wherever a crash cuts: the rows whose ends of line are there.
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::ofstream(file, std::ios::binary) << whole.substr(0, length);
    const auto rows =
        static_cast<std::size_t>(std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length), '\n'));
    {
      TrialTable table = TrialTable::resume(file, codes, 42);
      BOOST_TEST(table.rows().size() == (rows > 0 ? rows - 1 : 0));
      table.add(row_number(9));
    }
    const TrialTable again = TrialTable::resume(file, codes, 42);
    BOOST_TEST(again.rows().size() == (rows > 0 ? rows : 1));
    BOOST_TEST(again.rows().back().trial == 9);
    BOOST_TEST(text_of_file(file).substr(0, header) == whole.substr(0, header));
  }
}

BOOST_AUTO_TEST_CASE(a_table_of_another_study_is_not_continued) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  BOOST_CHECK_THROW(TrialTable::resume(file, codes, 42), ValueError);
  TrialTable::begin(file, codes, 42).add(row_number(1));
  BOOST_CHECK_THROW(TrialTable::resume(file, codes, 43), ValueError);
  BOOST_CHECK_THROW(TrialTable::resume(file, {"A", "C"}, 42), ValueError);
  std::ofstream(file, std::ios::binary) << "t,x\n1,2\n";
  BOOST_CHECK_THROW(TrialTable::resume(file, codes, 42), ValueError);
}
