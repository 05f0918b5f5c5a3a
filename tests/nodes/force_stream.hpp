// What tests of the force nodes share: stamps, a context, and a step with one message.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/node/node.hpp"

namespace tactor::test {

inline Stamp stamp_ms(double ms, std::uint64_t sequence = 0) {
  const Time t = Time::from_seconds(ms * 1e-3);
  return {t, t, sequence};
}

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

struct Draw {
  explicit Draw(std::uint64_t seed) : engine(seed) {}
  double uniform(double a, double b) { return boost::random::uniform_real_distribution<double>(a, b)(engine); }
  double normal(double sigma = 1) { return sigma * standard(engine); }
  Vec3 normal_vector(double sigma = 1) { return {normal(sigma), normal(sigma), normal(sigma)}; }
  boost::random::mt19937_64 engine;
  boost::random::normal_distribution<double> standard;
};

/// The last n samples of x_t = sum_i phi_i x_{t-i} + noise, an axis a stream of its own, once the start is forgotten.
inline std::vector<Vec3> auto_regressive(const std::vector<double>& phi, std::size_t n, std::uint64_t seed,
                                         double sigma = 1) {
  Draw draw(seed);
  std::vector<Vec3> x;
  for (std::size_t t = 0; t < n + 500; ++t) {
    Vec3 next = draw.normal_vector(sigma);
    for (std::size_t i = 0; i < phi.size() && i < t; ++i) next += phi[i] * x[t - 1 - i];
    x.push_back(next);
  }
  return {x.end() - static_cast<std::ptrdiff_t>(n), x.end()};
}

}  // namespace tactor::test
