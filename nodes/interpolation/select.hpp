// One of several displayed curves, which can be changed while the run goes on.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"
#include "nodes/interpolation/force_state.hpp"

namespace tactor {

/// interpolation.select: F(t) = F_use(t) + e(t), F_use the newest segment of the input in use, e the displayed force
/// against it when another input comes into use. e decays as in Blend (decayed_twice), so that nothing of F jumps. When
/// it has decayed the segments of the input in use go through unchanged.
class Select final : public Node {
 public:
  enum class Use { first, second, third, fourth };
  struct Params {
    Use use = Use::first;
    Duration blend_time;
    double rate = 0;
  };
  Select(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  /// Throws InputError where no edge ends at the input in use.
  void start(StepContext& context) override;
  void step(StepContext& context) override;
  /// Why it cannot have these parameters; empty where it can. From any thread.
  [[nodiscard]] std::string refuses(const Params& params) const;
  /// From the next step on.
  void tune(const Params& params) { params_ = params; }

  Input<ForceSegment> first, second, third, fourth;
  Output<ForceSegment> segment;

 private:
  [[nodiscard]] const Input<ForceSegment>& input(Use use) const;
  void show(Time valid, const ForceSegment& next);

  Params params_;
  Duration tick_;
  std::optional<Use> in_use_;  // none: nothing has been displayed yet
  std::optional<Time> blended_until_;
  std::optional<std::uint64_t> passed_;  // the sequence of the newest segment that went through
  ForceSegment shown_;
};

}  // namespace tactor
