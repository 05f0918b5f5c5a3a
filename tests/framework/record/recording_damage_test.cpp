// Files that are no recordings, damaged ones and full disks give errors with the path, never a crash.
#include <sys/resource.h>
#include <sys/wait.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <csignal>

#include "framework/core/check.hpp"
#include "framework/core/describe.hpp"
#include "framework/core/shared_array.hpp"
#include "recording_fixture.hpp"

namespace recording_damage_test {

/// A message with an array, as a user's library may describe one.
struct Profile {
  tactor::SharedArray<double> heights;  // m
};

}  // namespace recording_damage_test

template <>
inline const tactor::MessageType& tactor::message_type<recording_damage_test::Profile>() {
  using recording_damage_test::Profile;
  static const MessageType type = Describe<Profile>("test.Profile").field("heights", "m", &Profile::heights).type();
  return type;
}

BOOST_AUTO_TEST_SUITE(recording_damage_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

std::filesystem::path make_recording(const Folder& folder) {
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_rows(*recorder, 2500);
  recorder->close();
  return folder / "a.h5";
}

/// Runs `work` in another process, which HDF5 may take down; its exit code, or -1 where a signal ended it.
template <class Work>
int in_child(Work work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  int status = 0;
  if (waitpid(child, &status, 0) != child) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

enum Outcome { intact = 0, refused = 1, wrong = 2 };

int read_all(const std::filesystem::path& path) {
  try {
    const auto reader = load_record_library().open(path);
    return read_and_compare(*reader) >= 0 && reader->header().graph == header.graph ? intact : wrong;
  } catch (const InputError& e) {
    return std::string(e.what()).find(path.string()) != std::string::npos ? refused : wrong;
  } catch (...) {
    return wrong;
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(messages_that_all_name_the_same_elements_are_refused_before_they_fill_the_memory) {
  constexpr std::uint64_t messages = 2000, each = 500;
  const Folder folder;
  const std::filesystem::path path = folder / "profiles.h5";
  // Of a process that is killed: its rows are not compressed, and nothing checks them.
  BOOST_REQUIRE(in_child([&] {
                  const auto recorder = load_record_library().create(path, header);
                  const std::size_t stream = recorder->add_stream("scan.profile", message_type<Profile>());
                  ArrayPool<double> pool(2, each);
                  for (std::uint64_t i = 0; i < messages; ++i) {
                    Profile profile;
                    profile.heights = *pool.copy(std::vector<double>(each, 1.0));
                    recorder->write(stream, stamp_of(static_cast<std::int64_t>(i)), &profile);
                  }
                  recorder->flush();
                  return 0;
                }) == 0);
  const auto read = [&] {
    const auto reader = load_record_library().open(path);
    MessageBatch batch(reader->streams()[0].type);
    reader->read(0, 0, reader->streams()[0].count, batch);
    return batch.size();
  };
  BOOST_TEST(read() > messages / 2);
  // Each message names its own elements, first and count; now each names all of them: 16 GB.
  std::string bytes = bytes_of(path);
  const auto range = [](std::uint64_t first, std::uint64_t count) {
    std::string text(16, '\0');
    std::memcpy(text.data(), &first, 8);
    std::memcpy(text.data() + 8, &count, 8);
    return text;
  };
  std::uint64_t patched = 0;
  for (std::uint64_t i = 1; i < messages; ++i) {
    const std::size_t at = bytes.find(range(i * each, each));
    if (at == std::string::npos) continue;
    bytes.replace(at, 16, range(0, messages / 2 * each));
    ++patched;
  }
  BOOST_TEST(patched > messages / 2);
  write_bytes(path, bytes);
  BOOST_CHECK_EXCEPTION(read(), InputError, [&](const InputError& error) {
    const std::string why = error.what();
    return why.find(path.string()) != std::string::npos && why.find("scan.profile") != std::string::npos &&
           why.find("at most 512 MiB") != std::string::npos;
  });
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  BOOST_TEST(used.ru_maxrss < 2 * 1024 * 1024);  // kB
}

BOOST_AUTO_TEST_CASE(missing_empty_and_foreign_files_are_refused_with_their_path) {
  const Folder folder;
  BOOST_TEST(read_all(folder / "missing.h5") == refused);
  write_bytes(folder / "empty.h5", "");
  BOOST_TEST(read_all(folder / "empty.h5") == refused);
  write_bytes(folder / "text.h5", "t,x\n0,1\n");
  BOOST_TEST(read_all(folder / "text.h5") == refused);
  BOOST_TEST(read_all(folder / ".") == refused);
}

BOOST_AUTO_TEST_CASE(a_recording_cut_anywhere_is_refused) {
  const Folder folder;
  const std::string whole = bytes_of(make_recording(folder));
  for (std::size_t k = 0; k < 40; ++k) {
    write_bytes(folder / "cut.h5", whole.substr(0, whole.size() * k / 40));
    BOOST_TEST(in_child([&] { return read_all(folder / "cut.h5"); }) == refused, k);
  }
  write_bytes(folder / "cut.h5", whole.substr(0, whole.size() - 1));
  BOOST_TEST(in_child([&] { return read_all(folder / "cut.h5"); }) == refused);
}

BOOST_AUTO_TEST_CASE(flipped_bytes_are_refused_or_harmless_and_never_change_a_value) {
  const Folder folder;
  const std::string whole = bytes_of(make_recording(folder));
  boost::random::mt19937 random(1);
  int refusals = 0;
  for (int k = 0; k < 300; ++k) {
    std::string damaged = whole;
    // Half of the flips go where the structure is: to the beginning of the file.
    const std::size_t end = k % 2 == 0 ? whole.size() : std::min<std::size_t>(whole.size(), 4096);
    const std::size_t at = boost::random::uniform_int_distribution<std::size_t>(0, end - 1)(random);
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << boost::random::uniform_int_distribution<int>(0, 7)(random)));
    write_bytes(folder / "damaged.h5", damaged);
    const int outcome = in_child([&] { return read_all(folder / "damaged.h5"); });
    BOOST_TEST((outcome == intact || outcome == refused), "flip at byte " << at << " ends in " << outcome);
    refusals += outcome == refused ? 1 : 0;
  }
  BOOST_TEST(refusals > 150);
}

BOOST_AUTO_TEST_CASE(a_path_that_cannot_be_written_is_refused_before_the_run) {
  const Folder folder;
  BOOST_CHECK_THROW(load_record_library().create(folder / "no/such/folder.h5", header), InputError);
  BOOST_CHECK_THROW(load_record_library().create(folder / ".", header), InputError);
}

BOOST_AUTO_TEST_CASE(a_full_disk_is_a_run_error_with_the_path_and_keeps_what_came_before) {
  for (const std::uint64_t bytes : {500'000, 700'000, 1'000'001}) {
    const Folder folder;
    const std::filesystem::path path = folder / "a.h5";
    const int outcome = in_child([&] {
      // A limit on file sizes stands for the full disk: write() then fails in the same place.
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{bytes, bytes};
      setrlimit(RLIMIT_FSIZE, &limit);
      int code = 3;
      try {
        const auto recorder = load_record_library().create(path, header);
        write_rows(*recorder, 20'000);
        recorder->close();
      } catch (const RunError& e) {
        code = std::string(e.what()).find(path.string()) != std::string::npos ? 0 : 4;
      } catch (...) {
        code = 5;
      }
      // The end of a process, with all that libraries do there.
      std::exit(code);
      return code;
    });
    BOOST_TEST(outcome == 0);
    BOOST_TEST(read_all(path) == intact);
    const auto reader = load_record_library().open(path);
    BOOST_TEST(!reader->complete());
    // All but the chunks that were being filled.
    std::uint64_t kept = 0;
    for (const RecordedStream& stream : reader->streams()) {
      std::size_t record = 24;
      for (const Field& field : stream.type.fields) record += count_of(field) * element_size(field);
      kept += stream.count * record;
    }
    BOOST_TEST(kept + 4 * 131'072 + 65'536 > bytes);
  }
}

BOOST_AUTO_TEST_SUITE_END()
