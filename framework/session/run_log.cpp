#include "framework/session/run_log.hpp"

#include <algorithm>
#include <cstring>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr const char* steps_stream = "steps";
constexpr const char* ticks_stream = "ticks";
constexpr const char* sets_stream = "sets";
constexpr const char* stop_stream = "stop";

/// The type of an event of this run, in which nodes have their names.
template <class Event>
const MessageType& event_type(const Plan& plan) {
  MessageType type = message_type<Event>();
  Field& node = type.fields.front();
  for (const NodeSpec& spec : plan.nodes) {
    node.enumerators.push_back({spec.name, static_cast<std::int64_t>(node.enumerators.size())});
  }
  lay_out(type);
  return keep_message_type(std::move(type));
}

template <class Event>
Event as(const void* value) {
  Event event;
  std::memcpy(static_cast<void*>(&event), value, sizeof event);
  return event;
}

/// Calls `take(stamp, event)` for each message of the stream, which all live recordings have.
template <class Event, class TakeEvent>
void for_each(RecordingReader& reader, const char* name, const MessageType& type, const TakeEvent& take) {
  const std::size_t stream = reader.find(name);
  const RecordedStream& info = reader.streams()[stream];
  if (!same_type(info.type, type)) {
    throw InputError(reader.path().string() + " cannot be replayed: its stream " + name +
                     " comes from other nodes than those of its graph, or from another version of tactor");
  }
  constexpr std::uint64_t block = 4096;
  MessageBatch messages(info.type);
  for (std::uint64_t first = 0; first < info.count; first += block) {
    messages.clear();
    reader.read(stream, first, std::min(block, info.count - first), messages);
    for (std::size_t i = 0; i < messages.size(); ++i) take(messages.stamp(i), as<Event>(messages.value(i)));
  }
}

/// The outputs that a program may feed and that somebody sees: an edge or a stream begins there.
std::vector<PlannedOutput> fed_outputs(const Plan& plan) {
  std::vector<PlannedOutput> found;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    for (std::size_t o = 0; plan.nodes[n].info->fed && o < plan.nodes[n].info->outputs.size(); ++o) {
      const bool read = std::any_of(plan.edges.begin(), plan.edges.end(),
                                    [&](const PlannedEdge& edge) { return edge.from == n && edge.output == o; });
      const bool recorded = std::any_of(plan.streams.begin(), plan.streams.end(), [&](const PlannedStream& stream) {
        return stream.node == n && stream.output == o;
      });
      if (read || recorded) found.push_back({n, o});
    }
  }
  return found;
}

/// `hand.message`
std::string name_of(const Plan& plan, const PlannedOutput& at) {
  return plan.nodes[at.node].name + "." + plan.nodes[at.node].info->outputs[at.output].name;
}

/// Refuses what no run of the plan tells.
class Check {
 public:
  Check(const RecordingReader& reader, const Plan& plan) : reader_(reader), plan_(plan), next_(plan.nodes.size(), 0) {}
  std::size_t node(std::int32_t index) const {
    if (index < 0 || static_cast<std::size_t>(index) >= plan_.nodes.size())
      refuse("it names a node that does not exist");
    return static_cast<std::size_t>(index);
  }
  /// A tick is of a node in the real-time lane, and tells of each edge into it.
  void lane(std::size_t node) const {
    if (plan_.nodes[node].scheduling.lane != Lane::realtime) refuse("a tick is of a node in another lane");
    const auto into = [node](const PlannedEdge& edge) { return edge.to == node; };
    if (std::count_if(plan_.edges.begin(), plan_.edges.end(), into) > static_cast<int>(TickEvent::most_inputs)) {
      refuse("node " + plan_.nodes[node].name + " has more inputs than a tick can record");
    }
  }
  /// Of the steps of a node none is missing.
  void step(std::size_t node, std::uint64_t sequence) {
    if (sequence != next_[node]++) refuse("some steps of node " + plan_.nodes[node].name + " were lost");
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(reader_.path().string() + " cannot be replayed: " + why);
  }

 private:
  const RecordingReader& reader_;
  const Plan& plan_;
  std::vector<std::uint64_t> next_;
};

/// The parameters of nodes as they are set one after the other.
class Parameters {
 public:
  explicit Parameters(const Plan& plan) : plan_(plan) {
    for (const NodeSpec& node : plan.nodes) nodes_.push_back(node);
  }
  std::shared_ptr<const void> set(std::size_t node, const std::string& text, const Check& check) {
    NodeSpec& spec = nodes_[node];
    const std::size_t equals = text.find('=');
    const auto param = spec.info->param(text.substr(0, equals));
    if (equals == std::string::npos || !param || !spec.info->params[*param].tunable) {
      check.refuse("it sets " + spec.name + "." + text + ", which is not tunable");
    }
    spec.params[*param] = parse_parameter(spec, *param, text.substr(equals + 1), "set " + spec.name + "." + text);
    return spec.info->tuning.value().typed(spec.params);
  }

 private:
  const Plan& plan_;
  std::vector<NodeSpec> nodes_;
};

}  // namespace

void record_run(Session& session, Recorder& recorder, const Write& write) {
  const auto into = [&write](std::size_t stream) {
    return [write, stream](const Stamp& stamp, const void* value) { write(stream, stamp, value); };
  };
  const Plan& plan = session.plan();
  const auto write_step = into(recorder.add_stream(steps_stream, event_type<StepEvent>(plan)));
  session.on_step([write_step, &plan](const Stamp& stamp, const void* value) {
    // Of a node in the real-time lane its ticks tell.
    const auto node = static_cast<std::size_t>(static_cast<const StepEvent*>(value)->node);
    if (plan.nodes[node].scheduling.lane != Lane::realtime) write_step(stamp, value);
  });
  session.on_tick(into(recorder.add_stream(ticks_stream, event_type<TickEvent>(plan))), std::size_t{8} << 20U);
  session.on_set(into(recorder.add_stream(sets_stream, event_type<SetEvent>(plan))));
  session.on_stop(into(recorder.add_stream(stop_stream, message_type<StopEvent>())));
  for (const PlannedOutput& fed : fed_outputs(plan)) {
    const std::string name = name_of(plan, fed);
    const auto recorded = [&name](const PlannedStream& stream) { return stream.name == name; };
    if (std::any_of(plan.streams.begin(), plan.streams.end(), recorded)) continue;
    session.on_message(name, into(recorder.add_stream(name, type_of(plan, fed))));
  }
}

RunLog read_run_log(RecordingReader& reader, const Plan& plan) {
  RunLog log;
  Check check(reader, plan);
  Parameters parameters(plan);
  const auto reach = [&](Time t) {
    if (t < Time{}) check.refuse("it has a time before its start");
    log.end = std::max(log.end, t);
  };
  for_each<StepEvent>(reader, steps_stream, event_type<StepEvent>(plan),
                      [&](const Stamp& stamp, const StepEvent& event) {
                        const std::size_t node = check.node(event.node);
                        check.step(node, stamp.sequence);
                        reach(stamp.produced);
                        if (stamp.produced < stamp.valid) check.refuse("a step ends before it begins");
                        log.steps.push_back({node, stamp.valid, stamp.produced});
                      });
  for_each<TickEvent>(reader, ticks_stream, event_type<TickEvent>(plan),
                      [&](const Stamp& stamp, const TickEvent& event) {
                        const std::size_t node = check.node(event.node);
                        check.lane(node);
                        check.step(node, stamp.sequence);
                        reach(stamp.produced);
                        log.ticks.push_back({event, stamp.valid, stamp.produced});
                      });
  for_each<SetEvent>(reader, sets_stream, event_type<SetEvent>(plan), [&](const Stamp& stamp, const SetEvent& event) {
    const std::size_t node = check.node(event.node);
    const auto length = static_cast<std::size_t>(std::clamp(event.length, 0, static_cast<int>(SetEvent::most_text)));
    const std::string text(event.text.begin(), event.text.begin() + static_cast<std::ptrdiff_t>(length));
    reach(stamp.produced);
    if (text.empty() && !plan.nodes[node].info->sets) {
      check.refuse("it tells of a request of node " + plan.nodes[node].name + ", which makes none");
    }
    log.sets.push_back({node, stamp, event, text.empty() ? nullptr : parameters.set(node, text, check)});
  });
  for_each<StopEvent>(reader, stop_stream, message_type<StopEvent>(), [&](const Stamp& stamp, const StopEvent& event) {
    if (event.failed != 0) check.refuse("the run failed");
    reach(stamp.produced);
    log.stop = stamp.produced;
  });
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const NodeInfo& info = *plan.nodes[n].info;
    if (info.hardware) {
      check.refuse("node " + plan.nodes[n].name + " (" + info.type + ") talks to hardware, which cannot be made again");
    }
  }
  for (const PlannedOutput& at : fed_outputs(plan)) {
    const std::string name = name_of(plan, at);
    const std::size_t stream = reader.find(name);
    if (!same_type(reader.streams()[stream].type, type_of(plan, at))) {
      check.refuse("what was fed to " + name + " is of another type");
    }
    RunLog::Fed fed{at.node, at.output, MessageBatch(type_of(plan, at))};
    reader.read(stream, 0, reader.streams()[stream].count, fed.messages);
    for (std::size_t i = 0; i < fed.messages.size(); ++i) reach(fed.messages.stamp(i).produced);
    log.fed.push_back(std::move(fed));
  }
  return log;
}

}  // namespace tactor
