// Playback sends what a file holds, when it is due, with the stamps of the file.
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "framework/core/check.hpp"
#include "framework/record/recorder.hpp"
#include "nodes/source/csv_table.hpp"
#include "nodes/source/recording.hpp"

BOOST_AUTO_TEST_SUITE(recording_source_test)

using namespace tactor;

namespace {

const Scene scene;

NodeContext context_of() {
  NodeContext context;
  context.name = "playback";
  context.scene = &scene;
  return context;
}

struct TemporaryFile {
  explicit TemporaryFile(const std::string& text, const std::string& suffix = ".csv") {
    std::string name = (std::filesystem::temp_directory_path() / "tactor_XXXXXX").string() + suffix;
    const int descriptor = mkstemps(name.data(), static_cast<int>(suffix.size()));
    BOOST_REQUIRE(descriptor >= 0);
    ::close(descriptor);
    path = name;
    std::ofstream(path) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path); }
  std::filesystem::path path;
};

RecordingSource::Params params_of(const std::filesystem::path& file, Mapping columns) {
  RecordingSource::Params params;
  params.file = file;
  params.columns = std::move(columns);
  return params;
}

template <class T>
std::vector<Stamped<T>> step(RecordingSource& source, Output<T>& output, std::int64_t now_ns) {
  StepContext context(Time{now_ns});
  source.step(context);
  std::vector<Stamped<T>> sent;
  for (std::size_t i = 0; i < output.pending(); ++i) {
    sent.push_back({{output.pending_valid(i), {}, 0}, *static_cast<const T*>(output.pending_value(i))});
  }
  source.force.clear_pending();
  source.device.clear_pending();
  source.target.clear_pending();
  return sent;
}

std::filesystem::path rig_recording() {
  const char* folder = std::getenv("TACTOR_DATA");
  const std::filesystem::path data =
      folder != nullptr ? std::filesystem::path(folder) : std::filesystem::path(TACTOR_SOURCE_DIR) / "../shared/data";
  return data / "tue_1dof_teleop/m2_question1a_rigid.csv.gz";
}

struct NeedsRigRecording {
  boost::test_tools::assertion_result operator()(boost::unit_test::test_unit_id) const {
    boost::test_tools::assertion_result result(std::filesystem::exists(rig_recording()));
    if (!result) result.message() << rig_recording() << " is not there; set TACTOR_DATA to its folder's parent";
    return result;
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(csv_rows_are_sent_when_due_with_their_own_stamps_in_si_units) {
  const TemporaryFile file("t_ms,tau_mNm,Fy\n10,75,1\n10.5,150,2\n12,-75,3\n");
  RecordingSource source(params_of(file.path, {{"time", "t_ms"},
                                               {"force.x", "tau_mNm * -1 / 0.075 m"},
                                               {"force.y", "Fy [kN]"},
                                               {"torque.z", "tau [N m] * 2"}}),
                         context_of());
  BOOST_TEST(step(source, source.force, 9'999'999).empty());
  const auto first = step(source, source.force, 11'000'000);
  BOOST_REQUIRE(first.size() == 2U);
  BOOST_TEST(first[0].stamp.valid.ns == 10'000'000);
  BOOST_TEST(first[1].stamp.valid.ns == 10'500'000);
  BOOST_TEST(std::abs(first[0].value.force.x + 1) < 1e-15);
  BOOST_TEST(std::abs(first[1].value.force.x + 2) < 1e-15);
  BOOST_TEST(first[1].value.force.y == 2000.0);
  BOOST_TEST(first[1].value.force.z == 0.0);
  // The mapping's unit goes before the heading's.
  BOOST_TEST(first[1].value.torque.z == 300.0);
  BOOST_TEST(step(source, source.force, 11'500'000).empty());
  BOOST_TEST(step(source, source.force, 20'000'000).size() == 1U);
  BOOST_TEST(step(source, source.force, 30'000'000).empty());
}

BOOST_AUTO_TEST_CASE(positions_become_devices_and_targets_with_differences_as_velocities) {
  const TemporaryFile file("t_s,x_mm,rz_deg\n5,0,0\n5.1,10,9\n5.3,40,0\n");
  RecordingSource::Params params =
      params_of(file.path, {{"time", "t_s"}, {"position.x", "x"}, {"rotation.z", "rz_deg"}});
  params.begin = RecordingSource::Begin::at_zero;
  RecordingSource devices(params, context_of());
  const auto states = step(devices, devices.device, 300'000'000);
  BOOST_REQUIRE(states.size() == 3U);
  BOOST_TEST(states[0].stamp.valid.ns == 0);
  BOOST_TEST(states[2].stamp.valid.ns == 300'000'000);
  BOOST_TEST(std::abs(states[1].value.X_WD.p.x - 0.01) < 1e-16);
  BOOST_TEST(std::abs(states[0].value.V_WD.v.x - 0.1) < 1e-12);
  BOOST_TEST(std::abs(states[1].value.V_WD.v.x - 0.04 / 0.3) < 1e-12);
  BOOST_TEST(std::abs(states[2].value.V_WD.v.x - 0.15) < 1e-12);
  BOOST_TEST(std::abs(states[0].value.V_WD.w.z - std::numbers::pi / 2) < 1e-12);
  RecordingSource targets(params, context_of());
  const auto wanted = step(targets, targets.target, 100'000'000);
  BOOST_REQUIRE(wanted.size() == 2U);
  BOOST_TEST(std::abs(to_rotation_vector(wanted[1].value.X_WH.R).z - std::numbers::pi / 20) < 1e-15);
}

BOOST_AUTO_TEST_CASE(mappings_that_make_no_sense_are_refused_with_the_field) {
  const TemporaryFile file("t_s,F_N,plain\n0,1,1\n1,2,2\n");
  struct Case {
    Mapping mapping;
    const char* expected;
  };
  const std::vector<Case> cases{
      {{}, "playback: columns are expected beside a CSV file"},
      {{{"force.x", "F"}}, "playback.columns: the field time is not mapped"},
      {{{"time", "t"}}, "only time is mapped"},
      {{{"time", "t"}, {"force", "F"}}, "playback.columns: force is not a field; expected time, or one of force"},
      {{{"time", "t"}, {"force.x", "plain"}}, "force.x: the heading 'plain' names no unit; write it as `plain [unit]`"},
      {{{"time", "t"}, {"force.x", "plain [banana]"}}, "force.x: [banana] is not a unit"},
      {{{"time", "t"}, {"force.x", "F * 2 m"}}, "force.x: the column comes out in N m, expected N"},
      {{{"time", "t"}, {"force.x", "F * two"}}, "force.x: 'two' does not start with a number"},
      {{{"time", "t"}, {"force.x", "F / 0"}}, "force.x: a factor of 0"},
      {{{"time", "t"}, {"force.x", "F"}, {"force.x", "F"}}, "force.x is mapped twice"},
      {{{"time", "plain [h] * -1"}, {"force.x", "F"}}, ":3: the time does not increase"},
      {{{"time", "plain [s] * 1e300"}, {"force.x", "F"}}, "is out of range"},
  };
  for (const Case& c : cases) {
    BOOST_CHECK_EXCEPTION(RecordingSource(params_of(file.path, c.mapping), context_of()), InputError,
                          [&](const InputError& e) {
                            BOOST_TEST_MESSAGE(e.what());
                            return std::string(e.what()).find(c.expected) != std::string::npos;
                          });
  }
  BOOST_CHECK_EXCEPTION(RecordingSource(params_of(file.path, {{"time", "t"}, {"force.x", "G_N"}}), context_of()),
                        InputError, [&](const InputError& e) {
                          return std::string(e.what()).find("has no column 'G_N'; it has: t_s, F_N, plain") !=
                                 std::string::npos;
                        });
}

BOOST_AUTO_TEST_CASE(a_damaged_compressed_file_is_refused) {
  const TemporaryFile file(std::string("\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03garbage", 17), ".csv.gz");
  BOOST_CHECK_THROW(read_csv(file.path), InputError);
}

BOOST_AUTO_TEST_CASE(a_real_recording_of_a_rig_plays_back, *boost::unit_test::precondition(NeedsRigRecording{})) {
  RecordingSource::Params params =
      params_of(rig_recording(),
                {{"time", "t_s"}, {"force.x", "minus_Fh_Nm * -1 / 0.075 m"}, {"position.x", "x_master_rad * 0.075 m"}});
  params.begin = RecordingSource::Begin::at_zero;
  RecordingSource source(params, context_of());
  // 10,000 rows at 2 kHz; the first: -0.0820165 rad, minus_Fh -0.020322 N m.
  std::size_t sent = 0;
  for (std::int64_t ms = 0; ms < 5000; ++ms) {
    const auto forces = step(source, source.force, ms * 1'000'000);
    if (ms == 0) {
      BOOST_REQUIRE(forces.size() == 1U);
      BOOST_TEST(std::abs(forces[0].value.force.x - 0.27096) < 1e-12);
    } else {
      BOOST_TEST(forces.size() == 2U);
    }
    sent += forces.size();
  }
  BOOST_TEST(sent == 9999U);
  BOOST_TEST(step(source, source.force, 5'000'000'000).size() == 1U);
}

#ifdef TACTOR_HAS_HDF5
BOOST_AUTO_TEST_CASE(a_recorded_stream_is_sent_at_its_output_when_it_had_been_visible) {
  const TemporaryFile file("", ".h5");
  const auto recorder = load_record_library().create(file.path, {"graph", 1, "0"});
  const std::size_t stream = recorder->add_stream("coupling.force", message_type<Wrench>());
  const std::size_t forecast = recorder->add_stream("ar.forecast", message_type<Forecast>());
  for (std::int64_t i = 0; i < 3000; ++i) {
    const Wrench wrench{{double(i), 0, 0}, {0, 0, -double(i)}};
    // Valid at 10 i ms, visible 8 ms later.
    recorder->write(stream, {Time{i * 10'000'000}, Time{i * 10'000'000 + 8'000'000}, std::uint64_t(i)}, &wrench);
  }
  const Forecast one{};
  recorder->write(forecast, {}, &one);
  recorder->close();

  RecordingSource::Params params = params_of(file.path, {});
  BOOST_CHECK_THROW(RecordingSource(params, context_of()), InputError);
  params.stream = "coupling.forces";
  BOOST_CHECK_THROW(RecordingSource(params, context_of()), InputError);
  params.stream = "ar.forecast";
  RecordingSource forecasts(params, context_of());
  BOOST_TEST(same_type(forecasts.message.type(), message_type<Forecast>()));
  StepContext now(Time{});
  forecasts.step(now);
  BOOST_TEST(forecasts.message.pending() == 1U);
  BOOST_TEST(forecasts.force.pending() == 0U);
  params.stream = "coupling.force";
  RecordingSource source(params, context_of());
  BOOST_TEST(step(source, source.force, 7'999'999).empty());
  const auto first = step(source, source.force, 8'000'000);
  BOOST_REQUIRE(first.size() == 1U);
  BOOST_TEST(first[0].stamp.valid.ns == 0);
  const auto rest = step(source, source.force, 30'000'000'000);
  BOOST_REQUIRE(rest.size() == 2999U);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    BOOST_REQUIRE(rest[i].stamp.valid.ns == std::int64_t(i + 1) * 10'000'000);
    BOOST_REQUIRE((rest[i].value.force == Vec3{double(i + 1), 0, 0}));
    BOOST_REQUIRE((rest[i].value.torque == Vec3{0, 0, -double(i + 1)}));
  }
}
#endif

BOOST_AUTO_TEST_SUITE_END()
