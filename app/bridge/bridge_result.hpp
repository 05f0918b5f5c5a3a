// Makes the result of a step out of a client's message.
#pragma once

#include "app/bridge/bridge_messages.hpp"
#include "framework/session/physics_messages.hpp"

namespace tactor {

/// The result as a PhysicsLoop takes it. It points to `contacts` and `bodies`, which take those of the message.
PhysicsResult physics_result(const BridgeResult& message, ContactSet& contacts, BodyStates& bodies);

}  // namespace tactor
