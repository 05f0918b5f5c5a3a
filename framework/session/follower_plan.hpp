// The plan of a reference that follows a run while it goes on.
#pragma once

#include <string>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

class Registry;

/// What follows a run, and what of the run it needs.
struct FollowerPlan {
  /// An output of a device of the run, and the node of the plan that is fed with it.
  struct Fed {
    std::string output;
    std::string node;
  };
  Plan plan;
  std::vector<Fed> fed;
  std::string reference;  ///< the output of the plan that is the truth
  std::string judged;     ///< the output of the run that is compared with it
};

/// The reference run of `tested` with its devices replaced by feeds of what they showed: where a device tells the
/// `truth` of a state, that. So it has the physics of every sample of the device, and drives no hardware. Of several
/// sinks that compare a force with a reference it is that of the first. Throws InputError where there is none, and
/// where physics has another source than the devices.
FollowerPlan plan_follower(const Plan& tested, Registry& registry);

}  // namespace tactor
