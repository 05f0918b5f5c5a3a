#include "framework/realtime/flight_record.hpp"

#include "framework/core/describe.hpp"
#include "framework/core/message_json.hpp"

namespace tactor {

static_assert(sizeof(FlightTick) <= flight_body_bytes && sizeof(FlightDevice) == flight_body_bytes);
static_assert(sizeof(FlightExchange) <= flight_body_bytes && sizeof(FlightText) == flight_body_bytes);

const char* name_of(FlightEvent event) {
  constexpr std::array<const char*, flight_event_count> names{"setting", "not_finite",  "stalled",     "came_back",
                                                              "failed",  "line_opened", "line_failed", "crashed"};
  const auto index = static_cast<std::size_t>(event);
  return index < names.size() ? names[index] : "unknown";
}

template <>
const MessageType& message_type<FlightTick>() {
  static const MessageType type =
      Describe<FlightTick>("tactor.FlightTick", "", "A tick of a node in the real-time lane that is no device.")
          .field("lateness", "s", &FlightTick::lateness_s,
                 "From the deadline, of the first tick that it was late for, until its loop woke.")
          .field("body", "s", &FlightTick::body_s, "Time that the step took.")
          .field("input_age", "s", &FlightTick::input_age_s,
                 "By edge into the node, in the order of the plan: the time since its newest message was valid. NaN: "
                 "there is none.")
          .type();
  return type;
}

template <>
const MessageType& message_type<FlightDevice>() {
  static const MessageType type =
      Describe<FlightDevice>("tactor.FlightDevice", "W", "A tick of a device. Wrenches act on the device.")
          .field("lateness", "s", &FlightDevice::lateness_s,
                 "From the deadline, of the first tick that it was late for, until its loop woke.")
          .field("body", "s", &FlightDevice::body_s, "Time that the step took.")
          .field("p_WD", "m", &FlightDevice::p_WD, "Position of the handle.")
          .field("v_WD", "m/s", &FlightDevice::v_WD, "Velocity of the handle.")
          .field("wanted_force", "N", &FlightDevice::wanted_force, "Force before the gate. NaN: none has come.")
          .field("wanted_torque", "N m", &FlightDevice::wanted_torque, "Torque before the gate.")
          .field("commanded_force", "N", &FlightDevice::commanded_force, "Force after the gate.")
          .field("commanded_torque", "N m", &FlightDevice::commanded_torque, "Torque after the gate.")
          .field("result_age", "s", &FlightDevice::result_age_s,
                 "Time since the sample from which the force in use was made. NaN: there is none.")
          .field("sample_age", "s", &FlightDevice::sample_age_s, "Age of the newest sample of the device.")
          .field("gain", "1", &FlightDevice::gain, "Of the gate's ramp, 0 to 1.")
          .field("generated", "J", &FlightDevice::generated_J,
                 "Most energy that the motors had given, net. NaN: it is not counted.")
          .field("allowed", "J", &FlightDevice::allowed_J, "Energy that one encoder step and one cycle can bring.")
          .field("engagement", "1", &FlightDevice::engagement, "As SafetyState has it.")
          .field("cause", "1", &FlightDevice::cause, "As SafetyState has it.")
          .field("health", "1", &FlightDevice::health, "0: ok, 1: not ready, 2: read failed, 3: write failed.")
          .field("phase", "1", &FlightDevice::phase, "0: starting, 1: running, 2: stopping.")
          .type();
  return type;
}

template <>
const MessageType& message_type<FlightExchange>() {
  static const MessageType type =
      Describe<FlightExchange>("tactor.FlightExchange", "", "A cycle of the line to a device.")
          .field("effort", "1", &FlightExchange::effort, "By axis, N or N m, as the device was given it.")
          .field("q", "1", &FlightExchange::q, "By axis, m or rad, as the device showed it.")
          .field("took", "s", &FlightExchange::took_s, "From the command until the sample was there.")
          .field("command_age", "s", &FlightExchange::command_age_s, "Age of the command when the cycle began.")
          .field("generated", "J", &FlightExchange::generated_J, "Most energy that the motors had given, net.")
          .field("allowed", "J", &FlightExchange::allowed_J, "Energy that one encoder step and one cycle can bring.")
          .field("faults", "1", &FlightExchange::faults, "Bits of a fault that the device reports.")
          .field("error", "1", &FlightExchange::error, "Kind of the failure. 0: the cycle was good.")
          .field("verdict", "1", &FlightExchange::verdict, "0: the sample is believed.")
          .field("expired", "1", &FlightExchange::expired, "1: zero was given for a command that had expired.")
          .field("limited", "1", &FlightExchange::limited, "1: the efforts were shortened to the limits of the axes.")
          .field("cuts", "1", &FlightExchange::cuts, "Times that the command was cut so far.")
          .field("bounded", "1", &FlightExchange::bounded, "1: the energy bound changed the efforts.")
          .type();
  return type;
}

template <>
const MessageType& message_type<FlightText>() {
  static const MessageType type = Describe<FlightText>("tactor.FlightText", "", "An event in words, or a part of them.")
                                      .choice("event", &FlightText::event,
                                              {{name_of(FlightEvent::setting), FlightEvent::setting},
                                               {name_of(FlightEvent::not_finite), FlightEvent::not_finite},
                                               {name_of(FlightEvent::stalled), FlightEvent::stalled},
                                               {name_of(FlightEvent::came_back), FlightEvent::came_back},
                                               {name_of(FlightEvent::failed), FlightEvent::failed},
                                               {name_of(FlightEvent::line_opened), FlightEvent::line_opened},
                                               {name_of(FlightEvent::line_failed), FlightEvent::line_failed},
                                               {name_of(FlightEvent::crashed), FlightEvent::crashed}},
                                              "What happened.")
                                      .field("part", "1", &FlightText::part, "Number of this part, from 0.")
                                      .field("parts", "1", &FlightText::parts, "Parts of the words.")
                                      .field("length", "1", &FlightText::length, "Bytes of `text` in use.")
                                      .field("unused", "1", &FlightText::unused, "0.")
                                      .field("first", "1", &FlightText::first, "Sequence of the record with part 0.")
                                      .field("text", "1", &FlightText::text, "UTF-8.")
                                      .type();
  return type;
}

std::string flight_layout() {
  return to_json(message_type<FlightTick>()) + "\n" + to_json(message_type<FlightDevice>()) + "\n" +
         to_json(message_type<FlightExchange>()) + "\n" + to_json(message_type<FlightText>()) + "\n";
}

}  // namespace tactor
