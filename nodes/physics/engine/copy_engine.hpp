// A program's light copy of its simulator, as an engine that nodes step.
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "framework/core/light_copy.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/engine/stepped_engine.hpp"

namespace tactor {

/// Steps a program's light copy. Its numbers are the `position` of EngineNumbers. It knows no contacts. A step fails if
/// the program's function throws or returns something that is not finite.
class CopyEngine final : public SteppedEngine {
 public:
  /// For the node of `context`, whose scene's tool the copy moves. Steps nothing until it has a copy.
  explicit CopyEngine(const NodeContext& context);
  /// Copies the program's function, and makes room for its state. Allocates.
  void take(const LightCopy& copy);

  /// Throws RunError with the node's name if no program has given a copy.
  void check_given() const;
  /// Throws RunError with the node's name if the last step, which was to go on from `time`, failed.
  void check_stepped(Time time) const;

  [[nodiscard]] std::uint64_t identity() const override { return state_.size(); }
  [[nodiscard]] bool tool_rotates() const override { return tool_rotates_; }
  [[nodiscard]] EngineNumbers numbers() const override {
    return {.position = state_, .X_WT = tool_.X_WT, .V_WT = tool_.V_WT};
  }
  bool restore(const EngineNumbers& numbers) override;
  bool step(const CouplingParameters& coupling, const DeviceState& to, double h, ContactSet* found) override;
  /// Empty where the last step succeeded.
  [[nodiscard]] const char* failure() const override { return failure_; }
  [[nodiscard]] const EngineTool& tool() const override { return tool_; }

 private:
  const bool tool_rotates_;
  CopyFunction step_;
  std::vector<double> state_;
  EngineTool tool_;
  const char* failure_ = "";
  std::exception_ptr thrown_;  // whose text `failure_` is
};

/// Adds the longest sub-step of a copy, `substep`.
template <class N>
void declare_substep(Declare<N>& node) {
  node.template real<double>(
      "substep", &N::Params::substep,
      {.doc = "longest sub-step of the copy", .unit = "s", .default_value = 2.5e-4, .min = 1e-5, .max = 0.02});
}

}  // namespace tactor
