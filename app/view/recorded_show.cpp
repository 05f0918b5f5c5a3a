#include "app/view/recorded_show.hpp"

#include <cstring>
#include <memory>
#include <utility>

#include "app/run/replay.hpp"
#include "app/view/judge.hpp"
#include "framework/core/check.hpp"
#include "framework/core/message_batch.hpp"
#include "framework/graph/plan.hpp"
#include "framework/record/recorder.hpp"
#include "framework/session/run_log.hpp"

namespace tactor {

namespace {

/// Compares what a session sends with what was recorded.
class StreamCheck {
 public:
  StreamCheck(RecordingReader& reader, std::size_t stream, const MessageType& type)
      : name_(reader.streams()[stream].name), recorded_(type) {
    if (!same_type(type, reader.streams()[stream].type)) {
      different_ = true;
      return;
    }
    reader.read(stream, 0, reader.streams()[stream].count, recorded_);
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  void take(const Stamp& stamp, const void* value) {
    if (different_ || next_ >= recorded_.size()) {
      different_ = true;
      return;
    }
    const Stamp& before = recorded_.stamp(next_);
    // Arrays lie elsewhere: of them the stamps are enough.
    const bool equal =
        before.valid == stamp.valid && before.produced == stamp.produced &&
        (!recorded_.type().arrays.empty() || std::memcmp(recorded_.value(next_), value, recorded_.type().size) == 0);
    different_ = !equal;
    ++next_;
  }
  [[nodiscard]] bool is_equal() const { return !different_ && next_ == recorded_.size(); }

 private:
  std::string name_;
  MessageBatch recorded_;
  std::size_t next_ = 0;
  bool different_ = false;
};

Show remade(RecordingReader& reader, const Plan& plan, Registry& registry, bool reference, const ShowOptions& options) {
  std::unique_ptr<RunLog> log;
  if (plan.graph.clock == Clock::real) log = std::make_unique<RunLog>(read_run_log(reader, plan));
  Session session(plan, {.replay = log.get()});
  std::vector<std::unique_ptr<StreamCheck>> checks;
  for (const PlannedStream& stream : plan.streams) {
    const MessageType& type = *plan.nodes[stream.node].info->outputs[stream.output].type;
    checks.push_back(std::make_unique<StreamCheck>(reader, reader.find(stream.name), type));
    session.on_message(stream.name, [check = checks.back().get()](const Stamp& stamp, const void* value) {
      check->take(stamp, value);
    });
  }
  const std::unique_ptr<Follower> follower =
      reference ? judging_follower(session, registry, std::nullopt, options.note) : nullptr;
  Show show = show_of(session, follower.get(), options);
  for (const auto& check : checks) {
    if (!check->is_equal()) throw InputError("its run comes out differently here, in " + check->name());
  }
  return show;
}

}  // namespace

Show show_of_recording(const std::filesystem::path& recording, Registry& registry, bool reference,
                       const ShowOptions& options) {
  const std::unique_ptr<RecordingReader> reader = load_record_library().open(recording);
  Plan plan = recorded_plan(reader->header(), registry);
  // A recording does not say what its graph was called.
  plan.graph.name = recording.stem().string();
  try {
    if (!reader->complete()) throw InputError("its run did not close it");
    return remade(*reader, plan, registry, reference, options);
  } catch (const InputError& error) {
    options.note(recording.string() + " is shown as far as it was recorded: " + error.what());
  }
  return show_of(*reader, plan, options);
}

Show show_of_graph(GraphSpec graph, Registry& registry, bool reference, const ShowOptions& options) {
  graph.clock = Clock::virtual_;
  Session session(make_plan(std::move(graph)));
  const std::unique_ptr<Follower> follower =
      reference ? judging_follower(session, registry, std::nullopt, options.note) : nullptr;
  return show_of(session, follower.get(), options);
}

}  // namespace tactor
