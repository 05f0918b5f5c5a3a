// A safety gate driven tick by tick with inputs that are well unless a test spoils them.
#pragma once

#include <boost/test/unit_test.hpp>

#include "framework/realtime/safety_gate.hpp"

BOOST_TEST_DONT_PRINT_LOG_VALUE(tactor::Engagement)
BOOST_TEST_DONT_PRINT_LOG_VALUE(tactor::SafetyCause)

namespace tactor::test {

inline constexpr Duration tick_period{1'000'000};

/// p(x) = 3 x^2 - 2 x^3, written as the integral of 6 x (1 - x).
inline double ramp(double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  return x * x + 2 * x * x * (1 - x);
}

class Drive {
 public:
  explicit Drive(const SafetyLimits& limits) : gate(limits, tick_period) {
    input.wanted_D_W = Wrench{};
    input.fresh_segment = true;
    input.permitted = true;
  }

  /// One tick at `input.now`, which then moves on by a period.
  const SafetyOutput& tick() {
    output = gate.tick(input);
    input.now = input.now + tick_period;
    return output;
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }
  /// Well inputs until the gate is engaged on `wanted`.
  void engage(const Wrench& wanted_D_W) {
    input.wanted_D_W = wanted_D_W;
    for (int i = 0; i < 2000 && output.safety.engagement != Engagement::engaged; ++i) tick();
    tick();
  }

  SafetyGate gate;
  SafetyInput input;
  SafetyOutput output;
};

}  // namespace tactor::test
