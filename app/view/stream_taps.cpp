#include "app/view/stream_taps.hpp"

#include <algorithm>

namespace tactor {

namespace {

/// Room for two seconds of a 1 kHz device, of sets for the newest.
constexpr Queue row_queue{QueuePolicy::drop_oldest, 2048};
constexpr Queue pose_queue{QueuePolicy::drop_oldest, 256};
constexpr Queue set_queue{QueuePolicy::drop_oldest, 2};
/// The same messages wait for all shapes of a node, and a pool has arrays for so many.
constexpr Queue shared_queue{QueuePolicy::drop_oldest, 4};
/// The reference may come in bursts; of what nobody collects this much waits.
constexpr std::size_t most_reference = 65536;

const Queue& queue_of(const ShownStream& stream) {
  if (stream.is_set) return set_queue;
  if (stream.shares_arrays) return shared_queue;
  return stream.least_gap.ns > 0 ? pose_queue : row_queue;
}

}  // namespace

StreamTaps::StreamTaps(Session& session, Follower* follower, const DrawnScene& drawn, bool blind)
    : streams_(blind ? blind_streams(session.plan(), drawn) : shown_streams(session.plan(), drawn)) {
  for (const ShownStream& stream : streams_) sources_.push_back({session.tap(stream.output, queue_of(stream)), 0});
  if (follower == nullptr || blind) return;
  streams_.push_back(reference_stream("reference", session.plan().torque));
  sources_.push_back({});
  follower->on_reference([this](Time t, const Wrench& force) {
    const std::scoped_lock lock(mutex_);
    if (reference_.size() < most_reference) reference_.push_back({{t, t, 0}, force});
  });
}

void StreamTaps::take_reference() {
  std::vector<Stamped<Wrench>> taken;
  {
    const std::scoped_lock lock(mutex_);
    taken.swap(reference_);
  }
  for (const Stamped<Wrench>& force : taken) streams_.back().add(force.stamp, &force.value, rows_);
}

void StreamTaps::collect(std::size_t i) {
  const ShownStream& stream = streams_[i];
  Source& source = sources_[i];
  rows_.times.clear();
  rows_.values.clear();
  if (source.tap == nullptr) {
    take_reference();
  } else {
    while (const MessageView message = source.tap->take()) {
      if (stream.least_gap.ns > 0) {
        const double t = message.stamp->valid.seconds();
        if (t < source.next_row) continue;
        source.next_row = t + stream.least_gap.seconds();
      }
      stream.add(*message.stamp, message.value, rows_);
    }
  }
  if (rows_.times.empty()) return;
  if (stream.role != "predicted") end_ = std::max(end_, rows_.times.back());
  if (stream.is_set) {
    writer_.add_set(i, rows_.times.front(), rows_.values.size() / stream.columns.size(), rows_.values);
  } else {
    writer_.add_rows(i, rows_.times, rows_.values);
  }
}

std::string StreamTaps::collect() {
  for (std::size_t i = 0; i < streams_.size(); ++i) collect(i);
  return writer_.empty() ? std::string() : writer_.take(end_);
}

std::uint64_t StreamTaps::dropped() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    // Of a set, and of shapes, the newest is enough.
    if (sources_[i].tap != nullptr && !streams_[i].is_set && !streams_[i].shares_arrays)
      sum += sources_[i].tap->dropped();
  }
  return sum;
}

}  // namespace tactor
