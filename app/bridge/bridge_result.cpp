#include "app/bridge/bridge_result.hpp"

namespace tactor {

PhysicsResult physics_result(const BridgeResult& message, ContactSet& contacts, BodyStates& bodies) {
  PhysicsResult result{
      .time = message.time, .X_WT = {}, .V_WT = {}, .felt_D_W = message.felt, .contact_T_W = message.contact};
  if (message.tool) {
    result.X_WT = message.tool->X_WT;
    result.V_WT = message.tool->V_WT;
    result.without_rotation[0] = !message.tool->has_rotation.value_or(false);
  }
  if (message.contacts) {
    contacts.count = static_cast<std::int32_t>(message.contacts->size());
    for (std::size_t i = 0; i < message.contacts->size(); ++i) {
      const BridgeContact& one = (*message.contacts)[i];
      contacts.contact[i] = one.contact;
      contacts.pair[i] = one.pair;
      result.without_p_TC[i] = !one.has_p_TC.value_or(false);
    }
    result.contacts = &contacts;
  }
  if (message.bodies) {
    bodies.count = static_cast<std::int32_t>(message.bodies->size());
    for (std::size_t i = 0; i < message.bodies->size(); ++i) {
      const BridgeBody& one = (*message.bodies)[i];
      bodies.X_WB[i] = one.X_WB;
      bodies.V_WB[i] = one.V_WB;
      if (!one.has_rotation.value_or(false)) result.without_rotation.set(i);
    }
    result.bodies = &bodies;
  }
  return result;
}

}  // namespace tactor
