// A program's simulator that is its own light copy: a mass on the coupling, above a wall that is a spring and damper.
#pragma once

#include <span>

#include "framework/core/light_copy.hpp"

namespace tactor::test {

/// A ball of 50 g and a radius of 4 mm, by implicit Euler, without friction on the plane z = 0. Its state is six
/// numbers: place in m, and velocity in m/s.
struct MassAndWall {
  static constexpr std::size_t numbers = 6;
  static constexpr double mass = 0.05, radius = 4e-3, stiffness = 2000, damping = 2;

  static CopyTool tool(std::span<const double> s) {
    return {.X_WT = {{s[0], s[1], s[2]}, {}}, .V_WT = {{s[3], s[4], s[5]}, {}}};
  }

  /// m (v' - v) / h = k (x_D - x') + b (v_D - v') + K (r - z') - D v_z' in z where that is no pull, with x' = x + h v'.
  static CopyTool step(std::span<double> s, const CopyStep& step) {
    const double h = step.h, k = step.coupling.k_t, b = step.coupling.b_t;
    for (int i = 0; i < 3; ++i) {
      double& x = s[static_cast<std::size_t>(i)];
      double& v = s[static_cast<std::size_t>(i) + 3];
      const double pull = mass * v + h * (k * (step.handle.X_WD.p[i] - x) + b * step.handle.V_WD.v[i]);
      const double inertia = mass + h * b + h * h * k;
      const double free = pull / inertia;
      const bool touches = i == 2 && stiffness * (radius - x - h * free) - damping * free > 0;
      v = touches ? (pull + h * stiffness * (radius - x)) / (inertia + h * damping + h * h * stiffness) : free;
      x += h * v;
    }
    return tool(s);
  }
};

}  // namespace tactor::test
