#include "nodes/physics/geometry/signed_distance.hpp"

#include "nodes/physics/geometry/outward.hpp"

namespace tactor {

void SignedDistance::lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const {
  int hint = -1;
  for (std::size_t k = 0; k < 8; ++k) {
    if ((wanted >> k & 1) == 0) continue;
    const Nearest n = nearest({x.x[k], x.y[k], x.z[k]}, hint);
    bound[k] = rounded_down(n.distance);
    hint = n.face;
  }
}

}  // namespace tactor
