// Makes a live run again under the virtual clock: the same steps, at the same times, with the same messages.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "framework/core/message_batch.hpp"
#include "framework/engine/held_messages.hpp"
#include "framework/engine/lane_tick.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/engine/virtual_engine.hpp"

namespace tactor {

/// What a live run told of itself, in order of time. Nodes are indices into the plan.
struct RunLog {
  struct Step {
    std::size_t node = 0;
    Time begun, passed;
  };
  struct Tick {
    TickEvent event;
    Time deadline, told;
  };
  struct Set {
    std::size_t node = 0;
    Stamp stamp;
    SetEvent event;
    std::shared_ptr<const void> params;  ///< all of the node, as its struct; null: a request is done
  };
  /// What a program fed into an output of a node.
  struct Fed {
    std::size_t node = 0;
    std::size_t output = 0;
    MessageBatch messages;
  };
  std::vector<Step> steps;  ///< of nodes outside of the real-time lane
  std::vector<Tick> ticks;
  std::vector<Set> sets;
  std::vector<Fed> fed;      ///< in the order of nodes and outputs: that in which messages of one instant were sent
  std::optional<Time> stop;  ///< when the devices were told to ramp down
  Time end;                  ///< of the last thing that was told
};

/// Runs a plan by a log. A step takes what it took; a tick of the real-time lane sees the messages that it saw, a tick
/// that was missed is missed again, and what was set and fed comes when it came.
class ReplayEngine final : private ExternalInputs, public VirtualEngine {
 public:
  /// `plan` without costs is that of the live run; it and the log must outlive the engine.
  ReplayEngine(const Plan& plan, const RunLog& log, const EngineOptions& options = {});

  void start() override;
  void advance_to(Time t) override;

 protected:
  /// Behind the last thing that the log tells.
  [[nodiscard]] Time end() const override { return log_.end + Duration{1}; }

 private:
  struct Event {
    enum class Kind : std::uint8_t { tick, set, fed, stop };
    Time time;
    Kind kind = Kind::tick;
    std::size_t index = 0;    // into the log's list of that kind
    std::size_t message = 0;  // of `fed`
  };

  void on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) override;
  void on_phase(Phase /*phase*/) override {}
  void make(const Event& event);
  void tick(const RunLog::Tick& tick);

  /// Throws InputError where the newest message on an inner edge is not the one that the tick saw live.
  void check_seen(std::size_t edge, const RunLog::Tick& tick, std::uint64_t seen, const MessageView& newest) const;

  const RunLog& log_;
  const Chains chains_;
  std::vector<std::optional<LaneTick>> lanes_;  // by node; none outside of the real-time lane
  std::vector<Event> events_;
  std::size_t next_ = 0;
  std::vector<HeldMessages> held_;                                 // by edge: arrived, and not seen by a tick yet
  std::vector<std::vector<std::shared_ptr<const void>>> tunings_;  // by node of the real-time lane
  std::vector<std::uint64_t> tuned_;                               // by node: how many of them a tick was given
};

}  // namespace tactor
