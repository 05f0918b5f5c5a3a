// A recording holds what was written, for our reader and for h5py, also where the writer was killed.
#include <fcntl.h>
#include <malloc.h>
#include <sys/file.h>
#include <sys/wait.h>

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <csignal>
#include <cstdlib>
#include <map>
#include <sstream>
#include <thread>

#include "framework/core/check.hpp"
#include "framework/core/file_descriptor.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/csv.hpp"
#include "nodes/prediction/ar_coefficients.hpp"
#include "recording_fixture.hpp"

BOOST_AUTO_TEST_SUITE(recording_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

bool has_h5py(boost::unit_test::test_unit_id) {
  return std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") == 0;
}

struct NeedsH5py {
  boost::test_tools::assertion_result operator()(boost::unit_test::test_unit_id id) const {
    boost::test_tools::assertion_result result(has_h5py(id));
    if (!result) result.message() << "/usr/bin/python3 has no h5py";
    return result;
  }
};

int check_with_h5py(const std::filesystem::path& path, std::int64_t least, std::int64_t most, const char* mode,
                    bool complete) {
  std::ostringstream command;
  command << "/usr/bin/python3 " << TACTOR_SOURCE_DIR << "/tests/framework/record/check_recording.py " << path << ' '
          << least << ' ' << most << ' ' << mode << ' ' << complete;
  return std::system(command.str().c_str());
}

/// Writes 3000 rows in another process, flushes, writes 500 more and is killed without warning.
void write_and_be_killed(const std::filesystem::path& path) {
  const pid_t child = fork();
  BOOST_REQUIRE(child >= 0);
  if (child == 0) {
    const std::unique_ptr<Recorder> recorder = load_record_library().create(path, header);
    write_rows(*recorder, 3000);
    recorder->flush();
    for (std::int64_t i = 3000; i < 3500; ++i) {
      const Wrench wrench = wrench_of(i);
      recorder->write(0, stamp_of(i), &wrench);
    }
    raise(SIGKILL);
  }
  int status = 0;
  BOOST_REQUIRE(waitpid(child, &status, 0) == child);
  BOOST_REQUIRE(WIFSIGNALED(status));
}

}  // namespace

BOOST_AUTO_TEST_CASE(what_was_written_is_read_back) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_rows(*recorder, 2500);
  recorder->close();
  const auto reader = load_record_library().open(folder / "a.h5");
  BOOST_TEST(reader->complete());
  BOOST_TEST(reader->header().graph == header.graph);
  BOOST_TEST(reader->header().seed == header.seed);
  BOOST_TEST(reader->header().version == header.version);
  BOOST_REQUIRE(reader->streams().size() == 2U);
  BOOST_TEST(reader->streams()[reader->find("device.state")].count == 250U);
  BOOST_TEST(read_and_compare(*reader) == 2500);
  BOOST_CHECK_EXCEPTION(static_cast<void>(reader->find("device.stat")), InputError, [](const InputError& e) {
    return std::string(e.what()).find("it has: coupling.force, device.state") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(every_message_type_survives_byte_for_byte) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  // The types of all ports that there are.
  Registry registry({TACTOR_NODE_FOLDER});
  registry.load_all();
  BOOST_REQUIRE(registry.message_types().size() >= 13U);
  // Every byte of a field different from its neighbours; an enumeration has its last value.
  const auto payload_of = [](const MessageType& type) {
    std::vector<std::byte> payload(type.size);
    const auto fill = [&](const auto& self, const std::vector<Field>& fields, std::size_t begin) -> void {
      for (const Field& field : fields) {
        // An array, which stays empty here: no bytes but a pool's make one.
        if (field.changes_size) continue;
        const std::size_t size = element_size(field);
        for (std::size_t i = 0; i < count_of(field); ++i) {
          const std::size_t at = begin + field.offset + i * size;
          if (field.kind == FieldKind::record) {
            self(self, field.fields, at);
          } else if (!field.enumerators.empty()) {
            payload[at] = std::byte(field.enumerators.back().value);
          } else {
            for (std::size_t k = 0; k < size; ++k) payload[at + k] = std::byte((at + 7 * k) % 251);
          }
        }
      }
    };
    fill(fill, type.fields, 0);
    return payload;
  };
  std::map<std::string, std::size_t> streams;
  for (const auto& [name, type] : registry.message_types()) streams[name] = recorder->add_stream(name, *type);
  for (const auto& [name, type] : registry.message_types()) {
    recorder->write(streams[name], stamp_of(3), payload_of(*type).data());
  }
  recorder->close();
  const auto reader = load_record_library().open(folder / "a.h5");
  for (const auto& [name, type] : registry.message_types()) {
    const std::size_t stream = reader->find(name);
    BOOST_TEST(same_type(reader->streams()[stream].type, *type), name);
    MessageBatch messages(*type);
    reader->read(stream, 0, 1, messages);
    const std::vector<std::byte> expected = payload_of(*type);
    BOOST_TEST(std::equal(expected.begin(), expected.end(), messages.value(0)), name);
  }
}

BOOST_AUTO_TEST_CASE(a_long_graph_and_an_empty_stream_are_kept) {
  const Folder folder;
  RecordingHeader big = header;
  big.graph.assign(200'000, 'x');
  const auto recorder = load_record_library().create(folder / "a.h5", big);
  recorder->add_stream("a.b", message_type<Wrench>());
  recorder->close();
  const auto reader = load_record_library().open(folder / "a.h5");
  BOOST_TEST((reader->header().graph == big.graph));
  BOOST_TEST(reader->streams()[0].count == 0U);
}

BOOST_AUTO_TEST_CASE(the_same_messages_give_the_same_bytes_however_they_were_flushed) {
  const Folder folder;
  const auto first = load_record_library().create(folder / "a.h5", header);
  write_rows(*first, 2500);
  first->close();
  const auto second = load_record_library().create(folder / "b.h5", header);
  write_rows(*second, 2500, 7);
  second->close();
  BOOST_TEST((bytes_of(folder / "a.h5") == bytes_of(folder / "b.h5")));
}

BOOST_AUTO_TEST_CASE(an_independent_reader_finds_the_same, *boost::unit_test::precondition(NeedsH5py{})) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_rows(*recorder, 2500);
  recorder->flush();
  BOOST_TEST(check_with_h5py(folder / "a.h5", 2500, 2500, "swmr", false) == 0, "while the writer is at work");
  recorder->close();
  BOOST_TEST(check_with_h5py(folder / "a.h5", 2500, 2500, "plain", true) == 0, "closed");
}

BOOST_AUTO_TEST_CASE(a_killed_writer_leaves_what_it_had_flushed) {
  const Folder folder;
  write_and_be_killed(folder / "a.h5");
  {
    const auto reader = load_record_library().open(folder / "a.h5");
    BOOST_TEST(!reader->complete());
    BOOST_TEST(reader->header().graph == header.graph);
    BOOST_TEST(read_and_compare(*reader) >= 3000);
  }
  load_record_library().repair(folder / "a.h5");
  const auto reader = load_record_library().open(folder / "a.h5");
  BOOST_TEST(read_and_compare(*reader) >= 3000);
}

BOOST_AUTO_TEST_CASE(a_writer_killed_before_the_length_of_its_file_was_written_loses_nothing) {
  // The file's first bytes tell its length. Those of an early flush stand for a kill amid a later one.
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_rows(*recorder, 10, 1);
  std::string early = bytes_of(folder / "a.h5");
  for (std::int64_t i = 10; i < 3000; ++i) {
    const Wrench wrench = wrench_of(i);
    recorder->write(0, stamp_of(i), &wrench);
  }
  recorder->flush();
  std::string killed = bytes_of(folder / "a.h5");
  constexpr std::size_t superblock = 48;
  killed.replace(0, superblock, early, 0, superblock);
  write_bytes(folder / "b.h5", killed);
  BOOST_TEST(read_and_compare(*load_record_library().open(folder / "b.h5")) == 3000);
  load_record_library().repair(folder / "b.h5");
  BOOST_TEST(read_and_compare(*load_record_library().open(folder / "b.h5")) == 3000);
}

BOOST_AUTO_TEST_CASE(a_killed_writers_file_opens_elsewhere_in_swmr_mode_and_plainly_once_mended,
                     *boost::unit_test::precondition(NeedsH5py{})) {
  const Folder folder;
  write_and_be_killed(folder / "a.h5");
  BOOST_TEST(check_with_h5py(folder / "a.h5", 3000, 3500, "swmr", false) == 0);
  load_record_library().repair(folder / "a.h5");
  BOOST_TEST(check_with_h5py(folder / "a.h5", 3000, 3500, "plain", false) == 0);
}

BOOST_AUTO_TEST_CASE(a_write_half_a_second_after_the_last_flush_flushes_by_itself) {
  const Folder folder;
  const pid_t child = fork();
  BOOST_REQUIRE(child >= 0);
  if (child == 0) {
    const std::unique_ptr<Recorder> recorder = load_record_library().create(folder / "a.h5", header);
    write_rows(*recorder, 100);
    usleep(600'000);
    const Wrench wrench = wrench_of(100);
    recorder->write(0, stamp_of(100), &wrench);
    raise(SIGKILL);
  }
  int status = 0;
  BOOST_REQUIRE(waitpid(child, &status, 0) == child);
  BOOST_TEST(read_and_compare(*load_record_library().open(folder / "a.h5")) == 101);
}

BOOST_AUTO_TEST_CASE(a_writer_killed_at_any_moment_leaves_a_readable_file) {
  boost::random::mt19937 random(3);
  for (int k = 0; k < 25; ++k) {
    const Folder folder;
    int started[2];
    BOOST_REQUIRE(pipe(started) == 0);
    const pid_t child = fork();
    BOOST_REQUIRE(child >= 0);
    if (child == 0) {
      const std::unique_ptr<Recorder> recorder = load_record_library().create(folder / "a.h5", header);
      write_rows(*recorder, 1);
      recorder->flush();
      if (write(started[1], "x", 1) != 1) _exit(1);
      for (std::int64_t i = 1;; ++i) {
        const Wrench wrench = wrench_of(i);
        recorder->write(0, stamp_of(i), &wrench);
        if (i % 50 == 0) recorder->flush();
      }
    }
    // Its end alone stays open, so that a child that dies early is seen here.
    close(started[1]);
    char x = 0;
    BOOST_REQUIRE(read(started[0], &x, 1) == 1);
    usleep(boost::random::uniform_int_distribution<unsigned>(100, 30'000)(random));
    kill(child, SIGKILL);
    int status = 0;
    BOOST_REQUIRE(waitpid(child, &status, 0) == child);
    close(started[0]);
    BOOST_TEST(read_and_compare(*load_record_library().open(folder / "a.h5")) >= 1);
    load_record_library().repair(folder / "a.h5");
    BOOST_TEST(read_and_compare(*load_record_library().open(folder / "a.h5")) >= 1);
  }
}

BOOST_AUTO_TEST_CASE(a_file_being_written_is_neither_mended_nor_overwritten) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_rows(*recorder, 10);
  recorder->flush();
  BOOST_CHECK_THROW(load_record_library().repair(folder / "a.h5"), InputError);
  BOOST_CHECK_THROW(load_record_library().create(folder / "a.h5", header), InputError);
  recorder->close();
  BOOST_TEST(read_and_compare(*load_record_library().open(folder / "a.h5")) == 10);
}

/// As HDF5 and so h5py lock a file that they read.
class Looking {
 public:
  explicit Looking(const std::filesystem::path& path)
      : file_(::open(path.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC, 0666)) {
    BOOST_TEST_REQUIRE(::flock(file_.number(), LOCK_SH) == 0);
  }
  /// False where it fails; not by a check, because checks of several threads would race.
  [[nodiscard]] bool end() const { return ::flock(file_.number(), LOCK_UN) == 0; }

 private:
  FileDescriptor file_;
};

BOOST_AUTO_TEST_CASE(who_looks_for_a_moment_at_a_file_that_is_begun_keeps_nobody_from_writing_it) {
  const Folder folder;
  const Looking looking(folder / "a.h5");
  bool ended = false;
  std::jthread thread([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    ended = looking.end();
  });
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  thread.join();
  BOOST_TEST(ended);
  write_rows(*recorder, 10);
  recorder->close();
  BOOST_TEST(read_and_compare(*load_record_library().open(folder / "a.h5")) == 10);
}

BOOST_AUTO_TEST_CASE(who_goes_on_looking_is_named_as_the_reason) {
  const Folder folder;
  const auto names_the_reason = [](const InputError& error) {
    return std::string(error.what()).find("another program has it open; end that one first") != std::string::npos;
  };
  const Looking at_new(folder / "a.h5");
  BOOST_CHECK_EXCEPTION(load_record_library().create(folder / "a.h5", header), InputError, names_the_reason);
  write_and_be_killed(folder / "b.h5");
  Looking at_killed(folder / "b.h5");
  BOOST_CHECK_EXCEPTION(load_record_library().repair(folder / "b.h5"), InputError, names_the_reason);
  BOOST_TEST_REQUIRE(at_killed.end());
  load_record_library().repair(folder / "b.h5");
}

BOOST_AUTO_TEST_CASE(a_recorder_that_is_dropped_leaves_a_readable_incomplete_file) {
  const Folder folder;
  {
    const auto recorder = load_record_library().create(folder / "a.h5", header);
    write_rows(*recorder, 100);
  }
  const auto reader = load_record_library().open(folder / "a.h5");
  BOOST_TEST(!reader->complete());
  BOOST_TEST(read_and_compare(*reader) == 100);
}

BOOST_AUTO_TEST_CASE(the_csv_export_has_units_exact_times_and_numbers_that_read_back) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_rows(*recorder, 600);
  recorder->close();
  const auto reader = load_record_library().open(folder / "a.h5");
  std::stringstream csv;
  export_csv(*reader, reader->find("coupling.force"), csv);
  std::string line;
  std::getline(csv, line);
  BOOST_TEST(line ==
             "valid_s,produced_s,sequence,force_x [N],force_y [N],force_z [N],torque_x [N m],torque_y [N m],"
             "torque_z [N m]");
  std::int64_t i = 0;
  for (; std::getline(csv, line); ++i) {
    std::vector<double> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(std::strtod(cell.c_str(), nullptr));
    const Wrench w = wrench_of(i);
    const std::vector<double> expected{
        double(i) / 1e3, (double(i) + 0.25) / 1e3, double(i), w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y,
        w.torque.z};
    BOOST_TEST(cells == expected, boost::test_tools::per_element());
    if (i == 3) BOOST_TEST(line.substr(0, 25) == "0.003000000,0.003250000,3");
  }
  BOOST_TEST(i == 600);
  std::stringstream states;
  export_csv(*reader, reader->find("device.state"), states);
  std::getline(states, line);
  BOOST_TEST(line ==
             "valid_s,produced_s,sequence,p_WD_x [m],p_WD_y [m],p_WD_z [m],R_WD_w [1],R_WD_x [1],R_WD_y [1],"
             "R_WD_z [1],v_WD_x [m/s],v_WD_y [m/s],v_WD_z [m/s],w_WD_x [rad/s],w_WD_y [rad/s],w_WD_z [rad/s],"
             "buttons [1]");
}

BOOST_AUTO_TEST_CASE(a_recording_takes_no_more_memory_the_longer_it_is) {
  const Folder folder;
  const std::unique_ptr<Recorder> recorder = load_record_library().create(folder / "long.h5", header);
  constexpr std::size_t streams = 4;
  for (std::size_t s = 0; s < streams; ++s) {
    recorder->add_stream("stream" + std::to_string(s), message_type<Wrench>());
  }
  const auto in_use = [] {
    const struct mallinfo2 m = mallinfo2();
    return static_cast<std::int64_t>(m.uordblks + m.hblkhd);
  };
  constexpr std::int64_t warm = 4'096, rows = 200'000;
  std::int64_t before = 0, most = 0;
  for (std::int64_t i = 0; i < rows; ++i) {
    const Wrench wrench = wrench_of(i);
    for (std::size_t s = 0; s < streams; ++s) recorder->write(s, stamp_of(i), &wrench);
    if (i == warm) before = in_use();
    if (i > warm && i % 512 == 0) most = std::max(most, in_use());
  }
  // HDF5 would keep up to 1 MiB of each stream that has been written, of which nothing is read again. Its index of
  // chunks of 72 KiB grows by some bytes each.
  BOOST_TEST(most - before < 512 * 1024);
}

BOOST_AUTO_TEST_SUITE_END()
