// Messages of a type that this repository does not know go through recording, CSV and replay, and come back equal.
#include <boost/test/unit_test.hpp>
#include <fstream>
#include <sstream>

#include "framework/core/check.hpp"
#include "framework/core/message_json.hpp"
#include "framework/record/csv.hpp"
#include "recording_fixture.hpp"
#include "tests/scan_nodes/scan.hpp"

BOOST_AUTO_TEST_SUITE(message_types_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

constexpr std::int64_t scans = 300;

void write_scans(Recorder& recorder, std::size_t points, std::int64_t flush_every = 0) {
  const std::size_t stream = recorder.add_stream("scanner.scan", message_type<Scan>());
  ScanMaker maker(4, points);
  for (std::int64_t n = 0; n < scans; ++n) {
    const Scan scan = maker.make(n);
    recorder.write(stream, stamp_of(n), &scan);
    if (flush_every > 0 && n % flush_every == 0) recorder.flush();
  }
}

void check_scan(std::int64_t n, std::size_t points, const Stamp& stamp, const void* value) {
  ScanMaker maker(1, points);
  BOOST_REQUIRE(stamp.valid == stamp_of(n).valid);
  BOOST_REQUIRE(stamp.produced == stamp_of(n).produced);
  BOOST_REQUIRE(stamp.sequence == stamp_of(n).sequence);
  BOOST_REQUIRE(same_scan(*static_cast<const Scan*>(value), maker.make(n)));
}

/// Reads all scans, from somewhere in the middle first.
void check_recording(const std::filesystem::path& path, std::size_t points) {
  const auto reader = load_record_library().open(path);
  const std::size_t stream = reader->find("scanner.scan");
  const RecordedStream& info = reader->streams()[stream];
  BOOST_TEST(same_type(info.type, message_type<Scan>()));
  BOOST_REQUIRE(info.count == std::uint64_t{scans});
  for (const std::int64_t first : {17, 0}) {
    MessageBatch messages(info.type);
    reader->read(stream, static_cast<std::uint64_t>(first), info.count - static_cast<std::uint64_t>(first), messages);
    for (std::size_t i = 0; i < messages.size(); ++i) {
      check_scan(first + static_cast<std::int64_t>(i), points, messages.stamp(i), messages.value(i));
    }
  }
}

std::string refusal(const std::filesystem::path& csv) {
  try {
    import_csv(csv, message_type<Scan>(), [](const Stamp&, const void*) {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_recording_of_a_foreign_type_is_read_back_equal) {
  const Folder folder;
  for (const std::size_t points : {std::size_t{5}, std::size_t{9000}}) {
    const auto recorder = load_record_library().create(folder / "a.h5", header);
    write_scans(*recorder, points);
    recorder->close();
    check_recording(folder / "a.h5", points);
  }
}

BOOST_AUTO_TEST_CASE(arrays_are_written_to_the_same_bytes_however_they_were_flushed) {
  const Folder folder;
  const auto first = load_record_library().create(folder / "a.h5", header);
  write_scans(*first, 50);
  first->close();
  const auto second = load_record_library().create(folder / "b.h5", header);
  write_scans(*second, 50, 7);
  second->close();
  BOOST_TEST((bytes_of(folder / "a.h5") == bytes_of(folder / "b.h5")));
}

BOOST_AUTO_TEST_CASE(a_recording_that_was_not_closed_shows_whole_messages) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_scans(*recorder, 50);
  recorder->flush();
  std::filesystem::copy_file(folder / "a.h5", folder / "b.h5");
  check_recording(folder / "b.h5", 50);
}

BOOST_AUTO_TEST_CASE(every_message_type_goes_through_csv_and_back) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_scans(*recorder, 5);
  recorder->close();
  const auto reader = load_record_library().open(folder / "a.h5");
  std::ofstream(folder / "a.csv") << [&] {
    std::ostringstream text;
    export_csv(*reader, 0, text);
    return text.str();
  }();
  std::int64_t n = 0;
  import_csv(folder / "a.csv", message_type<Scan>(),
             [&n](const Stamp& stamp, const void* value) { check_scan(n++, 5, stamp, value); });
  BOOST_TEST(n == scans);
}

BOOST_AUTO_TEST_CASE(the_headings_of_a_csv_file_name_records_units_and_axes) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_scans(*recorder, 5);
  recorder->close();
  std::ostringstream text;
  export_csv(*load_record_library().open(folder / "a.h5"), 0, text);
  std::istringstream lines(text.str());
  std::string headings, row;
  std::getline(lines, headings);
  std::getline(lines, row);
  std::getline(lines, row);
  BOOST_TEST(
      headings.starts_with("valid_s,produced_s,sequence,turn [1],quality [1],begin [ns],points.p_SP_x [m],"
                           "points.p_SP_y [m],points.p_SP_z [m],points.echo [1],points.brightness [W/m^2],"
                           "bounds_0_0 [m],bounds_0_1 [m],"));
  BOOST_TEST(headings.find("heads[1].R_SH_w [1]") != std::string::npos);
  BOOST_TEST(row.starts_with("0.001000000,0.001250000,1,1,dusty,1000003,0.1,"), row);
}

BOOST_AUTO_TEST_CASE(a_csv_file_that_is_another_is_refused_with_its_line) {
  const Folder folder;
  const auto recorder = load_record_library().create(folder / "a.h5", header);
  write_scans(*recorder, 5);
  recorder->close();
  std::ostringstream text;
  export_csv(*load_record_library().open(folder / "a.h5"), 0, text);
  const std::string good = text.str();
  const auto file = folder / "a.csv";
  const auto changed = [&](const std::string& what, const std::string& by) {
    std::string bad = good;
    bad.replace(bad.find(what), what.size(), by);
    write_bytes(file, bad);
    return refusal(file);
  };
  BOOST_TEST(refusal(folder / "none.csv").find("there is no file") != std::string::npos);
  write_bytes(file, "");
  BOOST_TEST(refusal(file).ends_with("a.csv:1: the file is empty"));
  BOOST_TEST(changed("turn [1],", "turn,").find("have no column \"turn\"") != std::string::npos);
  BOOST_TEST(changed(",last [1]", "").find("need a column \"last [1]\"") != std::string::npos);
  BOOST_TEST(changed("dusty", "dirty").find("a.csv:3: quality [1]: there is no value \"dirty\"") != std::string::npos);
  BOOST_TEST(changed("1000003", "1e6").find("a.csv:3: begin [ns]: expected a number, found \"1e6\"") !=
             std::string::npos);
  BOOST_TEST(changed("0.001000000,", "0.001000000,,").find("a.csv:3: expected") != std::string::npos);
  BOOST_TEST(changed("0.001000000,", "soon,").find("a.csv:3: a time in s") != std::string::npos);
  BOOST_TEST(changed("0.2 1.2,", "0.2 1.2 2.2,").find("values, found") != std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
