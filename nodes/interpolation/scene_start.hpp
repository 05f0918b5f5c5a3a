// What interpolation.direct begins its steps from.
#pragma once

#include <cstdint>
#include <optional>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

/// Puts a rollout where physics results have the bodies, with the newest coupling that can be used. Counts the results
/// and couplings that cannot.
class SceneStart {
 public:
  /// Takes a coupling if it is new; a rollout that has begun learns it.
  void take(const Stamped<CouplingParameters>& coupling, LocalRollout& rollout);
  /// False before the first coupling, and for the results that were begun from or refused last.
  [[nodiscard]] bool is_new(const Stamped<BodyStates>& result) const;
  /// Puts the bodies where a new result has them, with the handle then. False where it is refused.
  bool begin(const Stamped<BodyStates>& result, const DeviceState& handle, LocalRollout& rollout);

  /// Null before the first one.
  [[nodiscard]] const CouplingParameters* coupling() const { return coupling_used_ ? &model_.coupling : nullptr; }
  [[nodiscard]] const Refusals& refusals() const { return refused_; }

 private:
  LocalModel model_;  // the newest result that was begun from, with the newest coupling
  std::optional<std::uint64_t> coupling_used_, begun_from_, rejected_;  // sequence numbers
  Refusals refused_{"results"};
};

}  // namespace tactor
