// What taps tell of a run, written down for tests.
#pragma once

#include <cstring>
#include <deque>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/engine/engine.hpp"
#include "framework/graph/plan.hpp"

namespace tactor::sample {

using Step = std::tuple<std::int64_t, std::size_t, std::int64_t>;                          // now, node, cost
using LoggedMessage = std::tuple<std::size_t, std::uint64_t, std::int64_t, std::int64_t>;  // stream, sequence, stamps

/// The steps of a run, and the wrenches of the plan's streams, in the order in which they became visible.
class EngineLog {
 public:
  /// Where steps are made on the caller's thread nothing is lost.
  EngineLog(Engine& engine, const Plan& plan) {
    const Queue queue{QueuePolicy::drop_newest, engine.steps_on_caller() ? 64U : 60000U};
    engine.with_dispatcher([&](Dispatcher& dispatcher) {
      dispatcher.add_step_tap(taps_.emplace_back(message_type<StepEvent>(), queue));
      for (const PlannedStream& stream : plan.streams) {
        dispatcher.add_tap(stream.node, stream.output, taps_.emplace_back(message_type<Wrench>(), queue));
      }
    });
    if (!engine.steps_on_caller()) return;
    for (Tap& tap : taps_) tap.when_full([this] { take(); });
  }
  EngineLog(const EngineLog&) = delete;
  EngineLog& operator=(const EngineLog&) = delete;

  /// Called for each message that is taken.
  std::function<void()> on_message = [] {};

  void take() {
    taps_.front().take_all([this](const Stamp& stamp, const void* value) {
      const auto& event = *static_cast<const StepEvent*>(value);
      steps.emplace_back(stamp.valid.ns, static_cast<std::size_t>(event.node), (stamp.produced - stamp.valid).ns);
    });
    for (std::size_t stream = 0; stream + 1 < taps_.size(); ++stream) {
      taps_[stream + 1].take_all([this, stream](const Stamp& stamp, const void* value) {
        Wrench w;
        std::memcpy(&w, value, sizeof w);
        messages.emplace_back(stream, stamp.sequence, stamp.valid.ns, stamp.produced.ns);
        values.push_back(w.force.x);
        values.push_back(w.force.y);
        on_message();
      });
    }
  }
  /// Steps as text, so that two runs can be compared whole.
  [[nodiscard]] std::string text() {
    take();
    std::string all;
    for (const auto& [now, node, cost] : steps) {
      all += std::to_string(node) + "@" + std::to_string(now) + "+" + std::to_string(cost) + "\n";
    }
    return all;
  }
  [[nodiscard]] std::uint64_t dropped() const {
    std::uint64_t sum = 0;
    for (const Tap& tap : taps_) sum += tap.dropped();
    return sum;
  }

  std::vector<Step> steps;
  std::vector<LoggedMessage> messages;
  std::vector<double> values;

 private:
  std::deque<Tap> taps_;
};

}  // namespace tactor::sample
