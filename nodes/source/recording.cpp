#include "nodes/source/recording.hpp"

#include <algorithm>
#include <cstring>

#include "framework/core/input_file.hpp"
#include "framework/core/value_error.hpp"
#include "framework/node/declare.hpp"
#include "framework/record/recorder.hpp"
#include "nodes/source/columns.hpp"
#include "nodes/source/csv_table.hpp"
#include "nodes/source/decimate.hpp"

namespace tactor {

namespace {

/// All of them are held, some 0.2 kB each.
constexpr std::uint64_t most_messages = csv_limits::rows;

template <class T>
std::vector<Stamped<T>> read_stream(RecordingReader& reader, std::size_t stream) {
  constexpr std::uint64_t block = 1024;
  std::vector<Stamped<T>> messages;
  std::vector<Stamp> stamps;
  std::vector<std::byte> payloads;
  const std::uint64_t count = reader.streams()[stream].count;
  messages.reserve(count);
  for (std::uint64_t first = 0; first < count; first += block) {
    reader.read(stream, first, std::min(block, count - first), stamps, payloads);
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      Stamped<T> message{stamps[i], {}};
      std::memcpy(&message.value, payloads.data() + i * sizeof(T), sizeof(T));
      messages.push_back(message);
    }
  }
  // Messages of one output become visible in order; a file of another origin need not keep to it.
  std::stable_sort(messages.begin(), messages.end(),
                   [](const Stamped<T>& a, const Stamped<T>& b) { return a.stamp.produced < b.stamp.produced; });
  return messages;
}

bool is_hdf5(const std::filesystem::path& file) {
  return file.extension() == ".h5" || file.extension() == ".hdf5";
}

}  // namespace

void RecordingSource::read_recording(const Params& params, const std::string& name) {
  const std::unique_ptr<RecordingReader> reader =
      about("file", [&] { return load_record_library().open(params.file); });
  const std::size_t stream = about("stream", [&] { return reader->find(params.stream); });
  const RecordedStream& found = reader->streams()[stream];
  if (found.count > most_messages) {
    throw ValueError("stream", name + ": " + params.file.string() + ": stream " + params.stream + " holds " +
                                   std::to_string(found.count) + " messages; at most " + std::to_string(most_messages) +
                                   " can be played back");
  }
  if (found.type == &message_type<Wrench>()) {
    force_.messages = read_stream<Wrench>(*reader, stream);
  } else if (found.type == &message_type<DeviceState>()) {
    device_.messages = read_stream<DeviceState>(*reader, stream);
  } else if (found.type == &message_type<Target>()) {
    target_.messages = read_stream<Target>(*reader, stream);
  } else {
    throw ValueError("stream", name + ": stream " + params.stream + " holds " + std::string(found.type->name) +
                                   "; only Wrench, DeviceState and Target can be played back");
  }
}

RecordingSource::RecordingSource(const Params& params, const NodeContext& context) {
  if (is_hdf5(params.file)) {
    if (params.stream.empty()) {
      throw ValueError("file",
                       context.name + ": stream is expected beside an .h5 file, for example stream: coupling.force");
    }
    if (!params.columns.empty())
      throw ValueError("columns", context.name + ": columns are for CSV files; leave them out");
    about("file", [&] { within_memory(params.file, [&] { read_recording(params, context.name); }); });
  } else {
    if (!params.stream.empty()) throw ValueError("stream", context.name + ": stream is for .h5 files; leave it out");
    if (params.columns.empty()) {
      throw ValueError(
          "file", context.name + ": columns are expected beside a CSV file, for example `time: t_s`, `force.x: F_N`");
    }
    const auto read = [&] {
      const CsvTable table = read_csv(params.file);
      return about("columns", [&] { return map_columns(table, params.columns, context.name + ".columns"); });
    };
    MappedMessages messages = about("file", [&] { return within_memory(params.file, read); });
    force_.messages = std::move(messages.force);
    device_.messages = std::move(messages.device);
    target_.messages = std::move(messages.target);
  }
  if (params.decimate > 1) {
    if (force_.messages.empty()) {
      throw ValueError("decimate",
                       context.name + ": decimate is for forces, and this recording gives none; leave it out");
    }
    force_.messages = about(
        "decimate", [&] { return decimated(std::move(force_.messages), params.decimate, context.name + ".decimate"); });
  }
  if (params.begin == Begin::at_zero) {
    begin_at_zero(force_);
    begin_at_zero(device_);
    begin_at_zero(target_);
  }
}

NodeInfo RecordingSource::declare() {
  return Declare<RecordingSource>("source.recording", "Plays a recording or a CSV file back with its own stamps.")
      .details(
          "An .h5 file needs `stream`, the recorded output such as coupling.force; it is sent at the output of its "
          "type. "
          "A CSV file (plain or .gz) needs `columns`, which maps fields to `heading [unit]` with optional factors "
          "(`force.x: minus_Fh_Nm * -1 / 0.075 m`). Fields: time; force and torque for the output force; position, "
          "rotation (a rotation vector), velocity and angular_velocity for the outputs device and target; each with .x "
          ".y .z. What is not mapped is 0, velocities that are not mapped are central differences. Each step sends all "
          "messages that became due since the one before, with the stamps of the file.")
      .output("force", &RecordingSource::force, "the recorded wrenches")
      .output("device", &RecordingSource::device, "the recorded device states")
      .output("target", &RecordingSource::target, "the recorded motion as a target of the hand")
      .haptic_rate(&Params::rate, {.doc = "how often it looks for messages that are due", .in_reference = 10000})
      .file("file", &Params::file, true, "the recording: .h5, or comma-separated values, plain or .gz")
      .text("stream", &Params::stream, "", "the stream of an .h5 file, `node.port`")
      .mapping("columns", &Params::columns, false, "for a CSV file: field to `heading [unit]` with optional factors")
      .choice("begin", &Params::begin, {{"as_recorded", Begin::as_recorded}, {"at_zero", Begin::at_zero}},
              std::optional(Begin::as_recorded), "keep the times of the file, or shift them so that the first is 0")
      .integer(
          "decimate", &Params::decimate,
          {.doc = "1 in so many samples of the force is kept, after a low-pass without phase at 0.4 of the new rate",
           .default_value = 1,
           .min = 1,
           .max = 100})
      .info();
}

template <class T>
void RecordingSource::begin_at_zero(Track<T>& track) {
  if (track.messages.empty()) return;
  const Duration shift = track.messages.front().stamp.valid - Time{};
  for (Stamped<T>& message : track.messages) {
    message.stamp.valid = message.stamp.valid - shift;
    message.stamp.produced = message.stamp.produced - shift;
  }
}

template <class T>
void RecordingSource::play(Track<T>& track, Output<T>& output, Time now) {
  while (track.next < track.messages.size() && track.messages[track.next].stamp.produced <= now) {
    output.send(track.messages[track.next].stamp.valid, track.messages[track.next].value);
    ++track.next;
  }
}

void RecordingSource::step(StepContext& context) {
  play(force_, force, context.now());
  play(device_, device, context.now());
  play(target_, target, context.now());
}

}  // namespace tactor
