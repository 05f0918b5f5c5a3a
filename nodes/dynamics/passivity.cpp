#include "nodes/dynamics/passivity.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

void PassivityObserver::observe(double change, double work, double stored) {
  const double excess = change - work;
  if (excess > 0) {
    generated_ += excess;
    largest_ = std::max(largest_, excess);
  } else {
    dissipated_ -= excess;
  }
  owed_ = std::clamp(owed_ + excess, 0.0, std::max(0.0, stored));
}

double PassivityObserver::dissipate(double allowed, double kinetic, BodyStates& bodies) {
  const double taken = std::min(owed_, kinetic) - allowed;
  if (!(taken > 0) || !std::isfinite(taken / kinetic)) return 0;
  const double factor = std::sqrt(1 - taken / kinetic);
  for (Twist& V : bodies.V_WB) {
    V.v *= factor;
    V.w *= factor;
  }
  owed_ -= taken;
  taken_ += taken;
  return taken;
}

}  // namespace tactor
