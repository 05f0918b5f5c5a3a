// The table of a participant: what it holds, what it refuses, and what a crash leaves of it.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/experiment/table.hpp"

BOOST_AUTO_TEST_SUITE(table_test)

using namespace tactor;

namespace {

TableOwner owner_of(std::uint64_t seed = 42, const std::vector<std::string>& codes = {"A", "B"},
                    const std::string& levels = "0.1 0.2") {
  TableOwner owner{codes, seed, {}};
  owner.design.add("levels", levels);
  owner.design.add("interval", "3");
  return owner;
}

/// What the disk was asked to keep: the paths of the files and folders.
std::vector<std::string> kept;

void note_kept(int file) {
  std::error_code error;
  kept.push_back(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file), error).string());
}

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
  row.limited_first = 0.125;
  row.peak_second = row.limited_second = std::numeric_limits<double>::quiet_NaN();
  return row;
}

std::string text_of_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// What every lock of this process answers; 0: what the system says.
int lock_error = 0;

bool names_participant(const ValueError& error) {
  return error.path() == "participant";
}

}  // namespace

// In the place of the C library's, which the table calls.
extern "C" int fsync(int file) {
  note_kept(file);
  return static_cast<int>(::syscall(SYS_fsync, file));
}

extern "C" int fdatasync(int file) {
  note_kept(file);
  return static_cast<int>(::syscall(SYS_fdatasync, file));
}

extern "C" int flock(int file, int operation) noexcept {
  errno = lock_error;
  return lock_error != 0 ? -1 : static_cast<int>(::syscall(SYS_flock, file, operation));
}

BOOST_AUTO_TEST_CASE(the_disk_keeps_the_folders_of_a_table_before_its_first_row_and_then_each_row) {
  const TemporaryFolder folder;
  const std::filesystem::path top = std::filesystem::canonical(folder.path());
  const std::filesystem::path file = top / "studies" / "jnd" / "P01.csv";
  kept.clear();
  TrialTable table = TrialTable::begin(file, owner_of());
  // The entry of each folder that was made is in the folder above it.
  for (const auto& path : {top, top / "studies", top / "studies" / "jnd", file}) {
    BOOST_TEST(std::count(kept.begin(), kept.end(), path.string()) > 0, path);
  }
  kept.clear();
  table.add(row_number(1));
  BOOST_TEST(std::count(kept.begin(), kept.end(), file.string()) == 1);
}

BOOST_AUTO_TEST_CASE(a_continued_table_is_kept_by_its_folder_too) {
  const TemporaryFolder folder;
  const std::filesystem::path file = std::filesystem::canonical(folder.path()) / "P01.csv";
  TrialTable::begin(file, owner_of()).add(row_number(1));
  kept.clear();
  static_cast<void>(TrialTable::resume(file, owner_of()));
  BOOST_TEST(std::count(kept.begin(), kept.end(), file.parent_path().string()) == 1);
}

BOOST_AUTO_TEST_CASE(a_code_is_letters_and_a_number_and_never_a_name) {
  BOOST_TEST(participant_code("P07").number == 7U);
  BOOST_TEST(participant_code("Q120").number == 120U);
  BOOST_TEST(participant_code("P0").number == 0U);
  // Names, initials with a year, dates of birth, and what a path could be made of.
  for (const char* name : {"", "Anna", "Anna Berg", "Jan07", "JB7", "p07", "xy120", "P1987", "P010790", "7", "1987",
                           "P", "Annabel1", "P-1", "P1a", "../P1", "P 1", "P.1", "\u00c41"}) {
    BOOST_CHECK_EXCEPTION(static_cast<void>(participant_code(name)), ValueError, [&](const ValueError& error) {
      return names_participant(error) &&
             std::string(error.what()).find("one capital letter and then one to three digits") != std::string::npos;
    });
  }
}

BOOST_AUTO_TEST_CASE(rows_are_read_back_as_they_were_written) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "study" / "P01.csv";
  {
    TrialTable table = TrialTable::begin(file, owner_of());
    for (int i = 1; i <= 3; ++i) table.add(row_number(i));
  }
  const TrialTable table = TrialTable::resume(file, owner_of());
  BOOST_REQUIRE(table.rows().size() == 3U);
  BOOST_TEST(table.rows()[2].level == 0.1 * 3);
  BOOST_TEST(table.rows()[2].response == 2);
  BOOST_TEST(table.rows()[2].condition == 1);
  BOOST_TEST(text_of_file(file).find("3,1,1,B,B,0.30000000000000004,2,2,1,0.25,1.5,,0.125,,42,") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_table_that_exists_is_not_written_over) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  TrialTable::begin(file, owner_of()).add(row_number(1));
  const std::string before = text_of_file(file);
  BOOST_CHECK_EXCEPTION(TrialTable::begin(file, owner_of()), ValueError, names_participant);
  BOOST_TEST(text_of_file(file) == before);
}

BOOST_AUTO_TEST_CASE(one_run_at_a_time_writes_a_table) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  const TrialTable first = TrialTable::begin(file, owner_of());
  BOOST_CHECK_THROW(TrialTable::resume(file, owner_of()), ValueError);
}

BOOST_AUTO_TEST_CASE(one_run_at_a_time_writes_a_table_where_the_file_system_has_no_locks) {
  for (const int error : {ENOSYS, ENOLCK, EOPNOTSUPP, EINVAL}) {
    lock_error = error;
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "P01.csv";
    {
      TrialTable first = TrialTable::begin(file, owner_of());
      first.add(row_number(1));
      BOOST_CHECK_EXCEPTION(TrialTable::resume(file, owner_of()), ValueError, names_participant);
      first.add(row_number(2));
    }
    BOOST_TEST(TrialTable::resume(file, owner_of()).rows().size() == 2U);
    BOOST_TEST(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
  }
  lock_error = 0;
}

BOOST_AUTO_TEST_CASE(a_row_that_was_cut_off_is_taken_away_and_the_others_stay) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  {
    TrialTable table = TrialTable::begin(file, owner_of());
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
      TrialTable table = TrialTable::resume(file, owner_of());
      BOOST_TEST(table.rows().size() == (rows > 0 ? rows - 1 : 0));
      table.add(row_number(9));
    }
    const TrialTable again = TrialTable::resume(file, owner_of());
    BOOST_TEST(again.rows().size() == (rows > 0 ? rows : 1));
    BOOST_TEST(again.rows().back().trial == 9);
    BOOST_TEST(text_of_file(file).substr(0, header) == whole.substr(0, header));
  }
}

BOOST_AUTO_TEST_CASE(a_table_of_another_study_is_not_continued) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "P01.csv";
  BOOST_CHECK_THROW(TrialTable::resume(file, owner_of()), ValueError);
  TrialTable::begin(file, owner_of()).add(row_number(1));
  BOOST_CHECK_THROW(TrialTable::resume(file, owner_of(43)), ValueError);
  BOOST_CHECK_THROW(TrialTable::resume(file, owner_of(42, {"A", "C"})), ValueError);
  BOOST_CHECK_EXCEPTION(
      TrialTable::resume(file, owner_of(42, {"A", "B"}, "0.1 0.3")), ValueError, [](const ValueError& error) {
        return std::string(error.what()).find("another design and cannot be continued: levels") != std::string::npos;
      });
  const auto refused = [&file](const std::string& text, const std::string& why) {
    std::ofstream(file, std::ios::binary) << text;
    BOOST_CHECK_EXCEPTION(TrialTable::resume(file, owner_of()), ValueError, [&why](const ValueError& error) {
      return std::string(error.what()).find(why) != std::string::npos;
    });
    BOOST_TEST(text_of_file(file) == text);
  };
  refused("t,x\n1,2\n", "found another file");
  refused(
      "trial,run,block,condition,other,level,comparison,response,correct,response_time_s,peak_1_N,peak_2_N,seed\n"
      "1,1,1,A,A,0.1,1,1,1,0.25,1.5,1.2,42\n",
      "of an earlier version");
}

BOOST_AUTO_TEST_CASE(a_digest_names_the_parts_that_differ_and_tells_none) {
  const auto design_of = [](const std::string& a, const std::string& b) {
    StudyDesign design;
    design.add("steps", a);
    design.add("secret", b);
    return design;
  };
  const StudyDesign design = design_of("1.6 1.25", "select.use=first");
  const std::string digest = design.digest();
  BOOST_TEST(digest.size() == 16U + 2 * 2U);
  BOOST_TEST(digest.find_first_not_of("0123456789abcdef") == std::string::npos);
  BOOST_TEST(design.differing(digest).empty());
  BOOST_TEST(design_of("1.6 1.2", "select.use=first").differing(digest) == "steps");
  BOOST_TEST(design_of("1.6 1.25", "select.use=third").differing(digest) == "secret");
  BOOST_TEST(design_of("1.6 1.2", "select.use=third").differing(digest) == "steps, secret");
  BOOST_TEST(design.differing("") == "its parts");
  // A thousand designs that differ in one character: none is taken for another.
  for (int i = 0; i < 1000; ++i) BOOST_TEST(!design_of("1.6", std::to_string(i)).differing(digest).empty());
}

BOOST_AUTO_TEST_SUITE_END()
