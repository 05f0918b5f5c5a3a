#include "nodes/source/recording.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

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

/// The messages of one type, in the order in which they became visible.
template <class T>
std::vector<Stamped<T>> as_messages(const MessageBatch& batch, const std::vector<std::size_t>& order) {
  std::vector<Stamped<T>> messages(batch.size());
  for (std::size_t i = 0; i < batch.size(); ++i) {
    messages[i].stamp = batch.stamp(order[i]);
    std::memcpy(&messages[i].value, batch.value(order[i]), sizeof(T));
  }
  return messages;
}

bool is_hdf5(const std::filesystem::path& file) {
  return file.extension() == ".h5" || file.extension() == ".hdf5";
}

/// The type of the stream that is to be played.
const MessageType& type_of_stream(const RecordingSource::Params& params) {
  if (!is_hdf5(params.file) || params.stream.empty()) return any_message();
  const std::unique_ptr<RecordingReader> reader = load_record_library().open(params.file);
  return keep_message_type(reader->streams()[reader->find(params.stream)].type);
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
  const MessageType& type = keep_message_type(found.type);
  messages_.emplace(type);
  reader->read(stream, 0, found.count, *messages_);
  // Messages of one output become visible in order; a file of another origin need not keep to it.
  order_.resize(messages_->size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::stable_sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
    return messages_->stamp(a).produced < messages_->stamp(b).produced;
  });
  message.set_type(type);
  if (same_type(type, message_type<Wrench>())) {
    force_.messages = as_messages<Wrench>(*messages_, order_);
  } else if (same_type(type, message_type<DeviceState>())) {
    device_.messages = as_messages<DeviceState>(*messages_, order_);
  } else if (same_type(type, message_type<Target>())) {
    target_.messages = as_messages<Target>(*messages_, order_);
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
  if (params.begin == Begin::at_zero) begin_at_zero();
}

NodeInfo RecordingSource::declare() {
  return Declare<RecordingSource>("source.recording", "Plays back a recording or a CSV file with its own stamps.")
      .details(
          "An .h5 file needs `stream`, the recorded output such as coupling.force. Its messages, of any type, are sent "
          "at the output message; wrenches also at force, device states also at device, and targets also at target. A "
          "CSV file (plain or .gz) needs `columns`, which maps fields to `heading [unit]` with optional factors "
          "(`force.x: minus_Fh_Nm * -1 / 0.075 m`). Fields: time; force and torque for the output force; position, "
          "rotation (a rotation vector), velocity and angular_velocity for the outputs device and target; each with .x "
          ".y .z. Fields that are not mapped are 0; velocities that are not mapped are central differences. Each step "
          "sends all messages that became due since the step before, with the stamps of the file.")
      .output("force", &RecordingSource::force, "the recorded wrenches")
      .output("device", &RecordingSource::device, "the recorded device states")
      .output("target", &RecordingSource::target, "the recorded motion as a target of the hand")
      .output("message", &RecordingSource::message, "the messages of the stream, of its type", type_of_stream)
      .haptic_rate(&Params::rate, {.doc = "how often it looks for messages that are due", .in_reference = 10000})
      .file("file", &Params::file, true, "the recording: .h5, or comma-separated values, plain or .gz")
      .text("stream", &Params::stream, "", "the stream of an .h5 file, `node.port`")
      .mapping("columns", &Params::columns, false, "for a CSV file: field to `heading [unit]` with optional factors")
      .choice("begin", &Params::begin, {{"as_recorded", Begin::as_recorded}, {"at_zero", Begin::at_zero}},
              std::optional(Begin::as_recorded), "keep the times of the file, or shift them so that the first is 0")
      .integer(
          "decimate", &Params::decimate,
          {.doc = "1 in this many samples of the force is kept, after a zero-phase low-pass at 0.4 of the new rate",
           .default_value = 1,
           .min = 1,
           .max = 100})
      .role(Role::source)
      .info();
}

void RecordingSource::begin_at_zero() {
  const auto shift = [](auto& messages) {
    if (messages.empty()) return;
    const Duration begin = messages.front().stamp.valid - Time{};
    for (auto& one : messages) {
      one.stamp.valid = one.stamp.valid - begin;
      one.stamp.produced = one.stamp.produced - begin;
    }
  };
  shift(force_.messages);
  shift(device_.messages);
  shift(target_.messages);
  if (order_.empty()) return;
  const Duration begin = messages_->stamp(order_.front()).valid - Time{};
  for (std::size_t i = 0; i < messages_->size(); ++i) {
    messages_->stamp(i).valid = messages_->stamp(i).valid - begin;
    messages_->stamp(i).produced = messages_->stamp(i).produced - begin;
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
  for (; next_ < order_.size() && messages_->stamp(order_[next_]).produced <= context.now(); ++next_) {
    message.send(messages_->stamp(order_[next_]).valid, messages_->value(order_[next_]));
  }
}

}  // namespace tactor
