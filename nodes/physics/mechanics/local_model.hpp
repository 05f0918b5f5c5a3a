// The message from the predictor to the interpolation of a local rollout.
#pragma once

#include <cstdint>

#include "framework/core/messages.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/contact_correction.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"

namespace tactor {

/// The state and the contacts that a local rollout continues from.
struct LocalModel {
  Time time;
  DeviceState device;
  BodyStates bodies;
  Vec3 p_WT_result;      ///< m
  Wrench wrench_result;  ///< N, N m
  double law_error = 0;  ///< N
  std::int32_t law_unknown = 0;
  std::int32_t contacts_told = 0;
  CouplingParameters coupling;
  LocalContacts contacts;
  ContactCorrection correction;
  LocalPatch patch;
};

template <>
const MessageType& message_type<LocalModel>();

}  // namespace tactor
