// One moment of a live run as the flight recorder keeps it: plain data of fixed size.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "framework/core/message.hpp"

namespace tactor {

/// What a record holds.
enum class FlightKind : std::uint8_t {
  none,      ///< nothing has been written there
  tick,      ///< a FlightTick
  device,    ///< a FlightDevice
  exchange,  ///< a FlightExchange
  event,     ///< a FlightText
};

/// What happened, of a FlightText.
enum class FlightEvent : std::uint8_t {
  setting,      ///< a parameter was set: `k_0=1200`
  not_finite,   ///< the node began to send values that are NaN or infinite: the name of the output
  stalled,      ///< the step that began at the time of the record has not come back
  came_back,    ///< a stalled step has
  failed,       ///< the run fails: why, in words
  line_opened,  ///< the line to the device
  line_failed,  ///< a cycle of the line or an attempt to open it: the kind of the failure and why, in words
  crashed,      ///< the process got a signal that ends it: its name
};
inline constexpr int flight_event_count = 8;
/// The name of an event, as tables and files spell it.
const char* name_of(FlightEvent event);

/// A tick of a node in the real-time lane that is no device.
struct FlightTick {
  static constexpr std::size_t most_inputs = 8;
  float lateness_s = 0;  ///< from the deadline, of the first tick that it was late for, until its loop woke
  float body_s = 0;      ///< that the step took
  /// By edge into the node, in the order of the plan: the time since the newest message was valid; NaN: there is none.
  std::array<float, most_inputs> input_age_s = [] {
    std::array<float, most_inputs> none{};
    none.fill(std::numeric_limits<float>::quiet_NaN());
    return none;
  }();
};

using FlightVector = std::array<float, 3>;  ///< x, y, z

/// A tick of a device. Vectors are expressed in the world W; wrenches are on the device D.
struct FlightDevice {
  float lateness_s = 0;             ///< as in FlightTick
  float body_s = 0;                 ///< that the step took
  FlightVector p_WD{};              ///< m
  FlightVector v_WD{};              ///< m/s
  FlightVector wanted_force{};      ///< N, before the gate; NaN: the pipeline has sent none yet
  FlightVector wanted_torque{};     ///< N m
  FlightVector commanded_force{};   ///< N, after the gate
  FlightVector commanded_torque{};  ///< N m
  float result_age_s = 0;           ///< since the sample from which the force in use was made; NaN: there is none
  float sample_age_s = 0;           ///< of the device's newest sample
  float gain = 0;                   ///< of the gate's ramp, 0 to 1
  float generated_J = 0;            ///< counted on the line (LineTotals); NaN: nothing is counted
  float allowed_J = 0;
  std::uint8_t engagement = 0;  ///< as Engagement
  std::uint8_t cause = 0;       ///< as SafetyCause
  std::uint8_t health = 0;      ///< as DeviceHealth
  std::uint8_t phase = 0;       ///< as Phase
};

/// A cycle of the line to a device of hardware. The time of its record is that at which the command was given.
struct FlightExchange {
  std::array<float, 8> effort{};  ///< N or N m by axis, as the device was given it
  std::array<float, 8> q{};       ///< m or rad by axis, as the device showed it; of a failed cycle the last known
  float took_s = 0;               ///< from the command until the sample was there
  float command_age_s = 0;        ///< of the loop's newest command when the cycle began
  float generated_J = 0;          ///< as LineTotals
  float allowed_J = 0;
  std::uint32_t faults = 0;   ///< bits of a fault that the device reports; 0: none
  std::uint8_t error = 0;     ///< as LinkError; 0: the cycle was good
  std::uint8_t verdict = 0;   ///< as Plausibility::Verdict; 0: the sample is believed
  std::uint8_t expired = 0;   ///< 1: zero was given for a command that had expired
  std::uint8_t limited = 0;   ///< 1: the efforts were shortened to the limits of the axes
  std::uint32_t cuts = 0;     ///< times that the command was cut so far
  std::uint32_t bounded = 0;  ///< 1: the energy bound changed the efforts
};

/// Words that belong to an event, or a part of them.
struct FlightText {
  static constexpr std::size_t most_bytes = 88;
  FlightEvent event = FlightEvent::setting;
  std::uint8_t part = 0;    ///< from 0
  std::uint8_t parts = 1;   ///< that the words are in
  std::uint8_t length = 0;  ///< bytes of `text` in use
  std::uint32_t unused = 0;
  std::uint64_t first = 0;                      ///< the sequence of the record with part 0
  std::array<std::uint8_t, most_bytes> text{};  ///< UTF-8
};

/// The largest of the four, with which every record is as large as two lines of the cache.
inline constexpr std::size_t flight_body_bytes = 104;

struct FlightRecord {
  std::uint32_t checksum = 0;  ///< over all that follows
  FlightKind kind = FlightKind::none;
  std::uint8_t unused = 0;
  std::uint16_t node = 0;      ///< index into the plan; FlightRecord::no_node: none
  std::uint64_t sequence = 0;  ///< counts the records of the run, from 0
  std::int64_t time_ns = 0;    ///< of CLOCK_MONOTONIC
  std::array<std::byte, flight_body_bytes> body{};

  static constexpr std::uint16_t no_node = 0xffff;
};
static_assert(sizeof(FlightRecord) == 128);

template <>
const MessageType& message_type<FlightTick>();
template <>
const MessageType& message_type<FlightDevice>();
template <>
const MessageType& message_type<FlightExchange>();
template <>
const MessageType& message_type<FlightText>();

/// The description of the four bodies, one a line in JSON: two programs with the same text can read each other's files.
std::string flight_layout();

}  // namespace tactor
