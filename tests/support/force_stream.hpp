// A context, a step with one message, and streams of forces, for tests of the force nodes.
#pragma once

#include <vector>

#include "framework/core/messages.hpp"
#include "framework/node/node.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::test {

inline NodeContext context(bool torque = true) {
  static const Scene scene;
  NodeContext c;
  c.name = "node";
  c.scene = &scene;
  c.torque = torque;
  c.duration = Duration::from_seconds(1);
  return c;
}

/// Pushes `value` to `in`, steps `node` at the stamp's time of production and returns the last message of `out`.
template <class In, class Out>
Out step_with(Node& node, Input<In>& in, const Stamp& stamp, const In& value, Output<Out>& out) {
  in.push(stamp, &value);
  StepContext c(stamp.produced);
  node.step(c);
  TACTOR_DEMAND(out.pending() > 0);
  const Out result = *static_cast<const Out*>(out.pending_value(out.pending() - 1));
  out.clear_pending();
  return result;
}

/// The last n samples of x_t = sum_i phi_i x_{t-i} + noise, an axis a stream of its own, once the start is forgotten.
inline std::vector<Vec3> auto_regressive(const std::vector<double>& phi, std::size_t n, std::uint64_t seed,
                                         double sigma = 1) {
  Dice draw(seed);
  std::vector<Vec3> x;
  for (std::size_t t = 0; t < n + 500; ++t) {
    Vec3 next = draw.normal_vector(sigma);
    for (std::size_t i = 0; i < phi.size() && i < t; ++i) next += phi[i] * x[t - 1 - i];
    x.push_back(next);
  }
  return {x.end() - static_cast<std::ptrdiff_t>(n), x.end()};
}

}  // namespace tactor::test
