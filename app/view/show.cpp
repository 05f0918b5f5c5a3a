#include "app/view/show.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "app/view/hello.hpp"
#include "app/view/samples.hpp"
#include "app/view/stream_taps.hpp"
#include "framework/core/check.hpp"
#include "framework/core/message_batch.hpp"
#include "framework/core/messages.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace {

/// Of a chunk: sets change as often.
constexpr Duration slice{33'000'000};
constexpr std::size_t frame_bytes = std::size_t{1} << 18U;

/// Joins chunks into frames.
class FrameMaker {
 public:
  explicit FrameMaker(std::vector<std::string>& frames) : frames_(frames) {}
  void add(const std::string& chunk) {
    if (chunk.empty()) return;
    bytes_ += chunk;
    ++chunks_;
    if (bytes_.size() >= frame_bytes) finish();
  }
  void finish() {
    if (chunks_ == 0) return;
    frames_.push_back(frame_header(chunks_, frames_.size() + 1) + bytes_);
    bytes_.clear();
    chunks_ = 0;
  }

 private:
  std::vector<std::string>& frames_;
  std::string bytes_;
  std::size_t chunks_ = 0;
};

/// `start`: of the handle; none where it was not shown.
HelloExtras extras_of(const Plan& plan, double duration, const std::optional<Pose>& start,
                      std::shared_ptr<const DrawnScene> drawn) {
  HelloExtras extras;
  extras.drawn = std::move(drawn);
  extras.replay = true;
  extras.duration = duration;
  if (const Body* tool = plan.graph.scene.tool(); tool != nullptr) extras.start = tool->X_WB;
  if (start) extras.start = *start;
  return extras;
}

/// The stream that shows the handle, an index into the list; none where there is none.
std::optional<std::size_t> handle_of(const std::vector<ShownStream>& streams) {
  for (std::size_t i = 0; i < streams.size(); ++i) {
    if (streams[i].role == "handle") return i;
  }
  return std::nullopt;
}

Pose pose_in(const void* state) {
  DeviceState message;
  std::memcpy(static_cast<void*>(&message), state, sizeof message);
  return message.X_WD;
}

void go_on(const ShowOptions& options, double share) {
  if (!options.progress(share)) throw RunError("interrupted");
}

/// The rows of a recorded stream as chunks; a set is a chunk of its own.
void add_recorded(RecordingReader& reader, const ShownStream& stream, std::size_t index, std::size_t recorded,
                  FrameMaker& maker, double& end) {
  constexpr std::uint64_t at_once = 4096;
  const RecordedStream& source = reader.streams()[recorded];
  ChunkWriter writer;
  double next_row = 0, next_set = 0;
  for (std::uint64_t first = 0; first < source.count; first += at_once) {
    MessageBatch batch(source.type);
    reader.read(recorded, first, std::min(at_once, source.count - first), batch);
    ShownRows rows;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const double t = batch.stamp(i).valid.seconds();
      if (t < (stream.is_set ? next_set : next_row)) continue;
      next_row = t + stream.least_gap.seconds();
      next_set = t + slice.seconds();
      stream.add(batch.stamp(i), batch.value(i), rows);
      if (!stream.is_set || rows.times.empty()) continue;
      writer.add_set(index, rows.times.front(), rows.values.size() / stream.columns.size(), rows.values);
      maker.add(writer.take(rows.times.front()));
    }
    if (rows.times.empty() || stream.is_set) continue;
    end = std::max(end, rows.times.back());
    writer.add_rows(index, rows.times, rows.values);
    maker.add(writer.take(rows.times.back()));
  }
}

}  // namespace

Show show_of(Session& session, Follower* follower, const ShowOptions& options) {
  Show show;
  const Plan& plan = session.plan();
  const auto drawn = std::make_shared<const DrawnScene>(drawn_scene(plan.graph));
  show.meshes = mesh_messages(*drawn, options.note);
  StreamTaps taps(session, follower, *drawn);
  FrameMaker maker(show.frames);
  std::optional<Pose> start;
  if (const auto handle = handle_of(taps.streams())) {
    session.on_message(taps.streams()[*handle].output, [&start](const Stamp&, const void* state) {
      if (!start) start = pose_in(state);
    });
  }
  const double planned = plan.graph.duration.seconds();
  session.run(slice, [&] {
    if (follower != nullptr) follower->follow();
    maker.add(taps.collect());
    go_on(options, std::min(session.now().seconds() / planned, 1.0));
  });
  const double end = session.now().seconds();
  if (follower != nullptr) follower->follow();
  maker.add(taps.collect());
  maker.finish();
  show.hello = hello_text(plan, taps.streams(), extras_of(plan, end, start, drawn));
  return show;
}

Show show_of(RecordingReader& reader, const Plan& plan, const ShowOptions& options) {
  Show show;
  const auto drawn = std::make_shared<const DrawnScene>(drawn_scene(plan.graph));
  show.meshes = mesh_messages(*drawn, options.note);
  std::vector<ShownStream> streams;
  std::vector<std::size_t> recorded;
  for (ShownStream& stream : shown_streams(plan, *drawn)) {
    for (std::size_t r = 0; r < reader.streams().size(); ++r) {
      const RecordedStream& there = reader.streams()[r];
      if (there.name != stream.output || there.count == 0) continue;
      recorded.push_back(r);
      streams.push_back(std::move(stream));
      break;
    }
  }
  FrameMaker maker(show.frames);
  double end = 0;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    add_recorded(reader, streams[i], i, recorded[i], maker, end);
    go_on(options, static_cast<double>(i + 1) / static_cast<double>(streams.size()));
  }
  maker.finish();
  std::optional<Pose> start;
  if (const auto handle = handle_of(streams)) {
    MessageBatch first(reader.streams()[recorded[*handle]].type);
    reader.read(recorded[*handle], 0, 1, first);
    start = pose_in(first.value(0));
  }
  show.hello = hello_text(plan, streams, extras_of(plan, end, start, drawn));
  return show;
}

}  // namespace tactor
