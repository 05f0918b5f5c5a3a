// A run under the virtual clock that the user may end, and the CPU times of its nodes without what it takes to read the
// clock.
#pragma once

#include <cstddef>
#include <functional>
#include <stdexcept>
#include <vector>

namespace tactor {

class Session;

/// The work was interrupted by the user.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Runs to the end. Asks `interrupted` every 10 ms of simulated time and throws Interrupted where it says true; throws
/// RunError as Session::advance does.
void run_to_end(Session& session, const std::function<bool()>& interrupted);

/// us of CPU time a simulated second of the first `nodes` nodes of the plan, of a run that measured them.
std::vector<double> node_costs(Session& session);

}  // namespace tactor
