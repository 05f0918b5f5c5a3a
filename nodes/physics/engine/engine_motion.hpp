// Moves a foreign engine through the samples of the handle.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "framework/core/engine_state.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/core/shared_array.hpp"
#include "nodes/physics/engine/stepped_engine.hpp"

namespace tactor {

/// An engine at a sample of the handle, and the steps from there to the next. Each interval between two samples is cut
/// into equal sub-steps, with the handle moving steadily from one to the other. Allocates nothing once it is made.
class EngineMotion {
 public:
  /// `engine` outlives it. `substep`: the longest sub-step, s.
  EngineMotion(SteppedEngine& engine, double substep) : engine_(engine), substep_(substep) {}

  /// Begins at that sample, with the engine as it is.
  void begin(const Stamped<DeviceState>& sample, const CouplingParameters& coupling) {
    sample_ = sample;
    coupling_ = coupling;
  }
  /// Why that state is not usable, but for the engine's own numbers: it is of another model, or not finite.
  [[nodiscard]] RefusalReason refusal(const EngineState& state) const;
  /// Goes to that state, from which these trees move; or why not: it is of another model, or not finite.
  [[nodiscard]] RefusalReason restart(const EngineState& state, Trees moving);
  /// The trees to move from that state on, as SteppedEngine::near_trees tells. `handle`: where it is by now;
  /// `step_budget` and `horizon`: s.
  [[nodiscard]] Trees near_trees(const EngineState& state, const DeviceState& handle, double horizon,
                                 double step_budget);
  /// Moves the bodies on to the time of `sample`; nothing happens where that is not later. False where the engine
  /// failed: then it has to be restarted. Contacts of the last sub-step are put into `found`, unless it is null.
  bool advance(const Stamped<DeviceState>& sample, const CouplingParameters& coupling, ContactSet* found = nullptr);

  /// The engine as it is, as a message; `result`: the state of the physics result behind it, or null where this is it.
  /// Empty where readers hold all arrays of the pool.
  [[nodiscard]] std::optional<EngineState> state(ArrayPool<double>& pool, const EngineState* result) const;

  /// Sub-steps from there to `time`, if no sample came between.
  [[nodiscard]] double substeps_to(Time time) const;

  /// s, the longest sub-step.
  [[nodiscard]] double substep() const { return substep_; }

  /// Of the sample that the bodies were moved to.
  [[nodiscard]] Time time() const { return sample_.stamp.valid; }
  /// Tool and handle at that time, with the contacts of the last sub-step.
  [[nodiscard]] PhysicsState tool_and_handle() const;
  /// m/s^2 and rad/s^2, of the tool between the last two samples.
  [[nodiscard]] const Twist& acceleration() const { return acceleration_; }
  [[nodiscard]] const SteppedEngine& engine() const { return engine_; }
  /// Whether all that can move does.
  [[nodiscard]] bool is_whole() const { return engine_.is_whole(moving_); }
  /// Sub-steps so far.
  [[nodiscard]] std::int64_t steps() const { return steps_; }

 private:
  SteppedEngine& engine_;
  double substep_;
  Trees moving_ = all_trees;
  Stamped<DeviceState> sample_;
  CouplingParameters coupling_;
  Twist acceleration_;
  std::int64_t steps_ = 0;
};

/// A pool for the arrays of `messages` states of that engine.
std::unique_ptr<ArrayPool<double>> engine_state_pool(const SteppedEngine& engine, std::size_t messages);

}  // namespace tactor
