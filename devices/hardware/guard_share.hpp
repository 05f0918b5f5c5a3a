// What an engine and the guard of its line have in common: the two slots, what the guard counts, and its configuration.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "devices/hardware/axis_gate.hpp"
#include "devices/hardware/line_cycle.hpp"
#include "devices/hardware/shared_slot.hpp"
#include "framework/core/bytes.hpp"
#include "framework/realtime/flight_ring.hpp"

namespace tactor {

/// A command on its way to a guard. All times are of CLOCK_MONOTONIC.
struct GuardOrder {
  LinkCommand command;
  Instant produced;         ///< when the loop gave it
  Instant deadline;         ///< from when on it has expired
  Instant zeroed;           ///< when the loop commanded zero last
  std::uint64_t epoch = 0;  ///< the cuts that the loop knew of: a command of an older epoch is refused
};

/// The texts of a guard about its own start; one line each.
struct GuardWords {
  std::atomic<std::uint32_t> size{0};  ///< bytes of the text; written last
  std::array<char, 1500> text{};
};

/// The shared memory. Its size is sealed.
struct GuardShare {
  SharedSlot<GuardOrder> orders;   ///< to the guard
  SharedSlot<LinkReport> reports;  ///< from it
  LineBoard board{true};           ///< the guard's
  GuardWords words;
};

/// Everything that a guard is told, once, before it starts; the engine cannot change it after that.
struct GuardConfig {
  std::uint64_t layout = 0;  ///< `guard_layout` of the engine: both must be of one build
  std::string line;          ///< `modbus`, `usb`, `falcon`
  std::string link;          ///< the bytes of what that line's link is made of
  AxisLimits limits;
  double rate = 1000;            ///< Hz, of the line's cycles
  Duration expires_after;        ///< the deadline of a command
  Duration let_go{3'000'000};    ///< from there to zero, linearly
  Duration age_max{50'000'000};  ///< see CommandTiming
  LineEnergyOptions energy;
  AxisGateLimits gate;
  std::string thread_name;
  FlightPlace flight;             ///< of the ring that is told each cycle, in the file guard_flight_file
  std::uint64_t flight_node = 0;  ///< see FlightWriter
};

void fields(auto& bytes, SameAs<AxisLimits> auto& l) {
  bytes(l.axes, l.role, l.pose, l.effort_max, l.speed_max, l.jump_tolerance, l.q_min, l.q_max, l.stuck_after,
        l.stuck_share);
}
void fields(auto& bytes, SameAs<LineEnergyOptions> auto& o) {
  bytes(o.axes, o.lever, o.step, o.period, o.delay_in, o.delay_out, o.held, o.lets_go, o.acceleration, o.slew, o.start,
        o.kept, o.stiffness, o.share, o.bounds);
}
void fields(auto& bytes, SameAs<FlightPlace> auto& p) {
  bytes(p.records_at, p.capacity);
}
void fields(auto& bytes, SameAs<GuardConfig> auto& c) {
  bytes(c.layout, c.line, c.link, c.limits, c.rate, c.expires_after, c.let_go, c.age_max, c.energy, c.gate,
        c.thread_name, c.flight, c.flight_node);
}

/// Tells builds apart whose shared memory lies otherwise.
inline constexpr std::uint64_t guard_layout =
    std::uint64_t{1} << 48U | std::uint64_t{sizeof(GuardShare)} << 16U | sizeof(GuardOrder);

/// The descriptors that a guard is started with. The last one is there if the configuration names the place of a ring.
inline constexpr int guard_config_file = 3, guard_share_file = 4, guard_engine_file = 5, guard_flight_file = 6;

}  // namespace tactor
