// forcefield.spring: the virtual wall of the textbooks, a spring and a damper at the device's sampled position.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"

namespace tactor {

/// With x_n the handle's coordinate along `axis` (m, in W) in the sample of t_n, x_0 the `position`, K and B:
///   v_n = (x_n - x_{n-1}) / (t_n - t_{n-1}), or the velocity that the device shows (m/s),
///   F_n = -K (x_n - x_0) - B v_n,
/// along the axis on the device, held until the next. Two-sided that is all of it, and linear. One-sided there is a
/// wall below x_0: F_n = max(0, F_n) where x_n < x_0, else 0, so it never pulls. Torque is zero.
///
/// v_0 is zero. Samples that are not finite, or not later than the one before, are left out and counted. A segment is
/// stamped as the sample that it was made from.
class SpringForceField final : public Node, public Refusing {
 public:
  enum class Sides : std::uint8_t { one, two };
  enum class Velocity : std::uint8_t { difference, device };
  enum class AxisName : std::uint8_t { x, y, z };
  struct Params {
    double stiffness = 0;  ///< N/m
    double damping = 0;    ///< N s/m
    Sides sides = Sides::one;
    Velocity velocity = Velocity::difference;
    AxisName axis = AxisName::z;
    double position = 0;  ///< m
    double rate = 0;      ///< Hz
  };
  SpringForceField(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }

  Input<DeviceState> device;
  Output<Wrench> force;
  Output<ForceSegment> segment;

 private:
  [[nodiscard]] double force_at(double x, double v) const;
  void take(Time now, const Stamped<DeviceState>& sample);

  Params params_;
  int axis_;
  NewMessages<DeviceState> samples_;
  bool any_ = false;
  double x_ = 0;  // m, of the sample before
  Time t_;        // of the same
  Refusals refused_{"samples"};
};

}  // namespace tactor
