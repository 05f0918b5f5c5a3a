#include "nodes/interpolation/scene_start.hpp"

namespace tactor {

void SceneStart::take(const Stamped<CouplingParameters>& coupling, LocalRollout& rollout) {
  if (coupling_used_ == coupling.stamp.sequence) return;
  coupling_used_ = coupling.stamp.sequence;
  const CouplingParameters before = model_.coupling;
  model_.coupling = coupling.value;
  if (model_.bodies.massless != 0) model_.coupling.massless = 1;
  // Before the first result there is nothing to learn for.
  if (!begun_from_ || rollout.learn(model_)) return;
  refused_.count(rollout.refusal(model_));
  model_.coupling = before;
}

bool SceneStart::is_new(const Stamped<BodyStates>& result) const {
  return coupling_used_ && begun_from_ != result.stamp.sequence && rejected_ != result.stamp.sequence;
}

bool SceneStart::begin(const Stamped<BodyStates>& result, const DeviceState& handle, LocalRollout& rollout) {
  const BodyStates before = model_.bodies;
  const std::int32_t massless = model_.coupling.massless;
  model_.time = result.stamp.valid;
  model_.device = handle;
  model_.bodies = result.value;
  model_.p_WT_result = result.value.X_WB[0].p;
  if (result.value.massless != 0) model_.coupling.massless = 1;
  refused_.count(rollout.refusal(model_));
  if (!rollout.restart(model_)) {
    model_.bodies = before;
    model_.coupling.massless = massless;
    rejected_ = result.stamp.sequence;
    return false;
  }
  begun_from_ = result.stamp.sequence;
  return true;
}

}  // namespace tactor
