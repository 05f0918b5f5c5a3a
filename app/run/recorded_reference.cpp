#include "app/run/recorded_reference.hpp"

#include <fmt/format.h>

#include <cstring>
#include <memory>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/messages.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// How much of a run a recording may lack at either end, and between two of its values.
constexpr Duration may_lack{100'000'000};
constexpr Duration longest_gap{50'000'000};

void refuse_bad_values(const MessageBatch& batch, const fs::path& recording, const RecordedStream& stream) {
  const bool is_wrench = same_type(batch.type(), message_type<Wrench>());
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const double at = batch.stamp(i).valid.seconds();
    if (i > 0 && batch.stamp(i).valid <= batch.stamp(i - 1).valid) {
      throw InputError(fmt::format("{}: stream {}: expected increasing times, found {} s after {} s (message {})",
                                   recording.string(), stream.name, at, batch.stamp(i - 1).valid.seconds(), i));
    }
    if (i > 0 && batch.stamp(i).valid - batch.stamp(i - 1).valid > longest_gap) {
      throw InputError(
          fmt::format("{}: stream {}: expected a value at least every {} s, found none from {:.6g} s to {:.6g} s",
                      recording.string(), stream.name, longest_gap.seconds(), batch.stamp(i - 1).valid.seconds(), at));
    }
    if (!is_wrench) continue;
    Wrench wrench;
    std::memcpy(&wrench, batch.value(i), sizeof wrench);
    if (is_finite(wrench)) continue;
    throw InputError(fmt::format("{}: stream {}: expected finite values, found one at {} s that is not (message {})",
                                 recording.string(), stream.name, at, i));
  }
}

ReferenceStream read_stream(RecordingReader& reader, const std::string& name, const MessageType& type, Duration run) {
  const fs::path& path = reader.path();
  const RecordedStream& stream = reader.streams()[reader.find(name)];
  if (!same_type(stream.type, type)) {
    throw InputError(fmt::format("{}: stream {}: expected messages of the type {}, found {}", path.string(), name,
                                 type.name, stream.type.name));
  }
  MessageBatch batch(type);
  within_memory(path, [&] { reader.read(reader.find(name), 0, stream.count, batch); });
  refuse_bad_values(batch, path, stream);
  const Time end = batch.size() == 0 ? Time{} : batch.stamp(batch.size() - 1).valid;
  if (batch.size() == 0 || end + may_lack < Time{} + run) {
    throw InputError(fmt::format("{}: stream {}: expected values up to the end of the run, {} s, found {}",
                                 path.string(), name, run.seconds(),
                                 batch.size() == 0 ? "none" : fmt::format("the last at {} s", end.seconds())));
  }
  if (batch.stamp(0).valid > Time{} + may_lack) {
    throw InputError(
        fmt::format("{}: stream {}: expected values from the beginning of the run, found the first at {} s",
                    path.string(), name, batch.stamp(0).valid.seconds()));
  }
  ReferenceStream found;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    found.stamps.push_back(batch.stamp(i));
    const auto* bytes = static_cast<const std::byte*>(static_cast<const void*>(batch.value(i)));
    found.payloads.insert(found.payloads.end(), bytes, bytes + type.size);
  }
  return found;
}

/// Refuses a plan whose hand moves otherwise than it did when the recording was made.
void refuse_unknown_paths(const Plan& plan) {
  const std::string graph = plan.graph.file.string();
  if (plan.graph.clock == Clock::real) {
    throw InputError(
        graph + ": expected clock: virtual, in which the hand moves as it did for the recording, found clock: real");
  }
  if (!must_be_followed(PlanNodes(plan))) return;
  throw InputError(graph +
                   ": expected a hand whose path does not depend on the forces, because the recording has only one "
                   "path; found a device in closed loop; add --set NODE.loop=open");
}

}  // namespace

Reference recorded_reference(const fs::path& recording, const Plan& plan) {
  refuse_unknown_paths(plan);
  Reference reference;
  const std::unique_ptr<RecordingReader> reader = load_record_library().open(recording);
  for (const PlannedEdge& edge : plan.edges) {
    const InputInfo& input = plan.nodes[edge.to].info->inputs[edge.input];
    if (!input.reference) continue;
    reference[edge.spec.to_node + "." + edge.spec.to_port] =
        read_stream(*reader, edge.spec.from_node + "." + edge.spec.from_port, *input.type, plan.graph.duration);
  }
  if (reference.empty()) {
    throw InputError(plan.graph.file.string() +
                     ": expected a node that compares the run with a reference, such as sink.metrics with an edge into "
                     "`force`, found none");
  }
  return reference;
}

fs::path recording_of(const std::string& pattern, const std::string& graph, std::uint64_t seed) {
  std::string path = pattern;
  const auto replace = [&path](std::string_view what, const std::string& by) {
    for (std::size_t at = path.find(what); at != std::string::npos; at = path.find(what, at + by.size())) {
      path.replace(at, what.size(), by);
    }
  };
  replace("{graph}", graph);
  replace("{seed}", std::to_string(seed));
  return path;
}

}  // namespace tactor
