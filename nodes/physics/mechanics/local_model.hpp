// What a local rollout goes on from, as the predictor sends it to the interpolation.
#pragma once

#include <cstdint>

#include "framework/core/messages.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/contact_correction.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"

namespace tactor {

/// What a local rollout goes on from: the moving bodies a physics result told of, brought on to the newest device
/// sample, and the contacts around them. Its message is stamped as the physics result.
struct LocalModel {
  Time time;             ///< of the device sample that the bodies were brought on to
  DeviceState device;    ///< that sample
  BodyStates bodies;     ///< at `time`
  Vec3 p_WT_result;      ///< m, of the tool in the physics result, at the message's stamp
  Wrench wrench_result;  ///< N and N m, of the coupling on the device in that result, within the device's limits
  /// N, of physics' contact wrench in that result what the contacts' law does not explain; 0 where nobody compares.
  double law_error = 0;
  std::int32_t law_unknown = 0;  ///< 1: physics of another law; nobody knows what the contacts' law gets wrong
  CouplingParameters coupling;
  LocalContacts contacts;        ///< as declared
  ContactCorrection correction;  ///< of those and of all that are found later
  LocalPatch patch;              ///< what deforms around the tool, at `time`; empty where nothing does
};

template <>
const MessageType& message_type<LocalModel>();

}  // namespace tactor
