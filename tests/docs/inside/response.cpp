#include <cstdio>

#include "devices/simulated/response.hpp"
#include "devices/simulated/simulated.hpp"

namespace tactor {

void print_response(const SimulatedDevice::Params& params) {
  BLOCK;
}

}  // namespace tactor
