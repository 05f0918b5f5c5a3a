#include "nodes/physics/engine/engine_motion.hpp"

#include <algorithm>
#include <cmath>
#include "framework/core/handle_between.hpp"
#include "framework/core/handle_gate.hpp"

#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

namespace {

EngineNumbers numbers_of(const EngineState& state) {
  const auto span = [](const SharedArray<double>& array) { return std::span(array.data(), array.size()); };
  return {span(state.position),     span(state.velocity), span(state.activation),
          span(state.acceleration), state.X_WT,           state.V_WT};
}

}  // namespace

RefusalReason EngineMotion::refusal(const EngineState& state) const {
  if (state.identity != engine_.identity()) return RefusalReason::another_scene;
  const bool is_good = is_usable(state.coupling) && is_usable(state.device) && is_finite(state.p_WT_result) &&
                       is_finite(state.wrench_result);
  return is_good ? RefusalReason::none : RefusalReason::not_finite;
}

RefusalReason EngineMotion::restart(const EngineState& state, Trees moving) {
  if (const RefusalReason why = refusal(state); why != RefusalReason::none) return why;
  engine_.let_move(moving);
  moving_ = moving;
  if (!engine_.restore(numbers_of(state))) return RefusalReason::another_scene;
  sample_ = {{.valid = state.time}, state.device};
  sample_.value.X_WD.R = normalized(state.device.X_WD.R);
  coupling_ = state.coupling;
  return RefusalReason::none;
}

Trees EngineMotion::near_trees(const EngineState& state, const DeviceState& handle, double horizon,
                               double step_budget) {
  return engine_.near_trees(numbers_of(state), {.horizon = horizon,
                                                .handle_speed = norm(handle.V_WD.v),
                                                .stretch = norm(handle.X_WD.p - state.p_WT_result),
                                                .step_budget = step_budget});
}

double EngineMotion::substeps_to(Time time) const {
  // The small allowance keeps an interval of exactly n sub-steps at n.
  return std::max(1.0, std::ceil((time - sample_.stamp.valid).seconds() / substep_ - 1e-6));
}

bool EngineMotion::advance(const Stamped<DeviceState>& sample, const CouplingParameters& coupling, ContactSet* found) {
  coupling_ = coupling;
  const double interval = (sample.stamp.valid - sample_.stamp.valid).seconds();
  if (interval <= 0) return true;
  const double count = substeps_to(sample.stamp.valid);
  const Twist before = engine_.tool().V_WT;
  for (double k = 1; k <= count; ++k) {
    const DeviceState to = handle_between(sample_.value, sample.value, k / count, engine_.tool_rotates());
    if (!engine_.step(coupling, to, interval / count, k == count ? found : nullptr)) return false;
    ++steps_;
  }
  const Twist& after = engine_.tool().V_WT;
  acceleration_ = {(after.v - before.v) / interval, (after.w - before.w) / interval};
  sample_ = sample;
  return true;
}

PhysicsState EngineMotion::tool_and_handle() const {
  const EngineTool& tool = engine_.tool();
  return {.X_WT = tool.X_WT,
          .V_WT = tool.V_WT,
          .X_WD = sample_.value.X_WD,
          .V_WD = sample_.value.V_WD,
          .contact_T_W = tool.contact_T_W,
          .contacts = tool.contacts};
}

std::optional<EngineState> EngineMotion::state(ArrayPool<double>& pool, const EngineState* result) const {
  const EngineNumbers numbers = engine_.numbers();
  auto position = pool.copy(numbers.position), velocity = pool.copy(numbers.velocity),
       activation = pool.copy(numbers.activation), acceleration = pool.copy(numbers.acceleration);
  if (!position || !velocity || !activation || !acceleration) return std::nullopt;
  return EngineState{.identity = engine_.identity(),
                     .moving = moving_,
                     .time = sample_.stamp.valid,
                     .device = sample_.value,
                     .X_WT = engine_.tool().X_WT,
                     .V_WT = engine_.tool().V_WT,
                     .p_WT_result = result != nullptr ? result->p_WT_result : engine_.tool().X_WT.p,
                     .wrench_result = result != nullptr
                                          ? result->wrench_result
                                          : coupling_wrench(coupling_, tool_and_handle(), engine_.tool_rotates()),
                     .coupling = coupling_,
                     .position = std::move(*position),
                     .velocity = std::move(*velocity),
                     .activation = std::move(*activation),
                     .acceleration = std::move(*acceleration)};
}

std::unique_ptr<ArrayPool<double>> engine_state_pool(const SteppedEngine& engine, std::size_t messages) {
  const EngineNumbers numbers = engine.numbers();
  const std::size_t longest =
      std::max({numbers.position.size(), numbers.velocity.size(), numbers.activation.size(), std::size_t{1}});
  constexpr std::size_t arrays_of_a_state = 4;
  return std::make_unique<ArrayPool<double>>(arrays_of_a_state * messages, longest);
}

}  // namespace tactor
