#include "nodes/physics/mechanics/local_model.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<LocalModel>() {
  static const MessageType type =
      Describe<LocalModel>("LocalModel", "W",
                           "The moving bodies of a physics result, moved on to the newest device sample, and the "
                           "contacts around them. Stamped as the physics result.")
          .field("time", &LocalModel::time, "Time of the device sample that the bodies were moved on to.")
          .field("device", &LocalModel::device, "Device sample at `time`.")
          .field("bodies", &LocalModel::bodies, "Moving bodies at `time`.")
          .field("p_WT_result", "m", &LocalModel::p_WT_result,
                 "Position of the origin of the tool T in the physics result, at the stamp of the message.")
          .field("wrench_result", &LocalModel::wrench_result,
                 "Wrench of the coupling on the device in that result, within the limits of the device.")
          .field("law_error", "N", &LocalModel::law_error,
                 "Part of the contact force of that result that the contact law does not explain; 0 where nothing "
                 "compares them.")
          .field("law_unknown", "1", &LocalModel::law_unknown,
                 "1: physics has another law of contact, so nobody knows how wrong that of the contacts is.")
          .field("contacts_told", "1", &LocalModel::contacts_told,
                 "1: physics told `contacts` with its result, and the surfaces of the scene tell no others.")
          .field("coupling", &LocalModel::coupling, "Spring and damper between handle and tool.")
          .field("contacts", &LocalModel::contacts, "Contacts around the bodies, before `correction`.")
          .field("correction", &LocalModel::correction)
          .field("patch", &LocalModel::patch,
                 "Deforming surface around the tool at `time`; empty where nothing deforms.")
          .type();
  return type;
}

}  // namespace tactor
