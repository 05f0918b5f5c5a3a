#include "devices/modbus/actuator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "devices/hardware/declare_hardware.hpp"
#include "devices/hardware/profile_files.hpp"
#include "devices/hardware/serial_ports.hpp"
#include "devices/modbus/profile_fields.hpp"
#include "framework/core/check.hpp"

namespace tactor::modbus {

namespace {

/// Of what the line can carry, where the graph leaves the rate open: room for a character more here and there.
constexpr double share_of_line = 0.95;

std::string text_of(const char* format, double a, double b = 0) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

void tell(const Setup& setup, std::vector<std::string>* notes) {
  if (notes != nullptr && !setup.danger.empty()) notes->push_back(setup.danger);
}

HardwareParts make_parts(const Actuator::Params& params, const NodeContext& context) {
  Setup setup = make_setup(params);
  tell(setup, context.notes);
  HardwareParts parts;
  std::vector<Vec3> directions;
  double finest = 1;
  for (std::size_t i = 0; i < setup.profile.axes.size(); ++i) {
    const Axis& axis = setup.profile.axes[i];
    directions.push_back(axis.direction);
    parts.limits.effort_max[i] = axis.effort_max;
    parts.limits.speed_max[i] = axis.speed_max;
    parts.limits.jump_tolerance[i] = axis.jump_tolerance;
    parts.effort_continuous[i] = axis.effort_continuous;
    parts.thermal_time[i] = axis.thermal_time;
    finest = std::min(finest, std::abs(setup.profile.registers[axis.position].scale));
  }
  parts.limits.axes = static_cast<int>(setup.profile.axes.size());
  parts.resolution = finest;
  parts.kinematics = std::make_unique<LinearKinematics>(directions);
  parts.rate = setup.rate;
  parts.buttons = static_cast<int>(setup.profile.buttons.size());
  if (setup.profile.watchdog) parts.watchdog = setup.profile.watchdog->time;
  ByteWriter bytes;
  bytes(setup.profile, setup.endpoint);
  parts.guardable = {"modbus", bytes.take()};
  parts.link = std::make_unique<ModbusLink>(std::move(setup.profile), std::move(setup.endpoint));
  return parts;
}

/// How long a cycle takes on the line of a setup, and with which settings.
std::string cycle_text(const Setup& setup) {
  std::string text = text_of("a cycle takes %.3g ms", 1e3 * setup.line.cycle_s);
  if (!setup.endpoint.serial) return text;
  const LineSettings& line = setup.profile.line;
  return text + " at " + std::to_string(line.baud) + " baud with " + std::to_string(line.character_bits()) +
         " bits a character";
}

/// A watchdog that is shorter than two cycles runs out where a single one is late, one that is shorter than a cycle
/// always. The profile is at fault, unless it is the graph that asks for so few cycles.
void check_watchdog(const Setup& setup, bool rate_of_graph) {
  if (!setup.profile.watchdog) return;
  constexpr double cycles = 2;
  const double time = setup.profile.watchdog->time.seconds();
  if (time * setup.rate >= cycles * (1 - 1e-9)) return;
  const double needed = cycles / time;
  const bool line_can = needed <= setup.line.rate;
  const std::string text =
      "the watchdog of " + setup.profile.name + ": expected a time of at least two cycles of the line, " +
      text_of("%.4g ms at %.4g Hz", 1e3 * cycles / setup.rate, setup.rate) +
      text_of(", found %.4g ms, at which the device would let go again and again; ", 1e3 * time) +
      (line_can ? text_of("set link_rate to %.4g Hz or more, or watchdog.time of the profile higher", needed)
                : text_of("the line carries at most %.4g Hz (", setup.line.rate) + cycle_text(setup) +
                      "): set watchdog.time of the profile higher");
  if (line_can && rate_of_graph) throw InputError(text);
  throw YamlError({{setup.profile.places.watchdog, text}});
}

/// What there is to know of a device that nothing makes let go when the commands end.
std::string danger_of(const Profile& profile, GuardChoice guard) {
  if (profile.watchdog) return {};
  const char* who = guard == GuardChoice::off ? "this program" : "its guard (tactor-guard, not this program)";
  return profile.name + ": its profile names no watchdog: if " + who +
         " is killed or the line is cut, the device may keep its last force; keep an emergency stop or its power "
         "switch within reach";
}

std::string calibrate(const Actuator::Params& params, const Ask& ask) {
  const Setup setup = make_setup(params);
  if (setup.profile.calibrate.empty()) return setup.profile.name + " needs no calibration";
  ModbusLink link(setup.profile, setup.endpoint);
  if (!ask(link.name() + ": put it where its zero should be and let it rest. It may move. Continue?"))
    return "nothing done";
  LinkFailure failure;
  if (!link.open(failure) || !link.calibrate(failure)) throw RunError(link.name() + ": " + failure.text);
  link.close();
  return link.name() + ": calibrated";
}

/// A line for each serial port that a Modbus line may be on. Nothing is sent to it: Modbus has no request that any
/// device may safely be given. Nor is anything known of what is on it, so that all profiles are looked at.
std::vector<std::string> discover(std::vector<std::string>& notes) {
  for (const std::filesystem::path& file : files_of(profiles_of("modbus"))) {
    try {
      static_cast<void>(plan_cycle(read_profile(file)));
    } catch (const InputError& error) {
      notes.push_back(broken_profile(file, error));
    }
  }
  std::vector<std::string> lines;
  for (const SerialPort& port : serial_ports()) {
    lines.push_back("serial port rtu:" + port.file.string() + ": " + port.adapter +
                    (port.may_open ? "" : "; this user may not open it: see `tactor doctor`"));
  }
  return lines;
}

}  // namespace

Setup make_setup(const Actuator::Params& params) {
  Setup setup{read_profile(params.profile), parse_endpoint(params.connect), 0, {}, {}};
  LineSettings& line = setup.profile.line;
  if (params.unit > 0) line.unit = params.unit;
  if (params.baud > 0) line.baud = params.baud;
  if (params.response_timeout.ns > 0) line.response_timeout = params.response_timeout;
  setup.line = line_rate(plan_cycle(setup.profile), line, setup.endpoint.serial);
  setup.rate = params.link_rate > 0 ? params.link_rate : std::min(params.rate, share_of_line * setup.line.rate);
  if (setup.rate > setup.line.rate) {
    throw InputError("link_rate: expected what the line of " + setup.profile.name + " can carry, " +
                     text_of("at most %.6g Hz; ", setup.line.rate) + cycle_text(setup) + ", found " +
                     text_of("%.6g Hz", params.link_rate));
  }
  // A sample must come before it is too old to be used.
  if (1 / setup.rate > params.link_timeout.seconds()) {
    throw InputError("link_timeout: expected at least a cycle of the line, " + text_of("%.3g ms", 1e3 / setup.rate) +
                     ", found " + text_of("%.3g ms", 1e3 * params.link_timeout.seconds()));
  }
  check_watchdog(setup, params.link_rate > 0);
  setup.danger = danger_of(setup.profile, params.guard);
  return setup;
}

Actuator::Actuator(const Params& params, const NodeContext& context)
    : HardwareDevice(params, context, make_parts(params, context)) {}

NodeInfo Actuator::declare() {
  Declare<Actuator> declaration("modbus.actuator", "A real actuator on Modbus, TCP or a serial line.");
  HardwareParams defaults;
  defaults.failure_timeout = Duration{5'000'000'000};
  declaration.details(
      "A profile says which registers the device has; docs/howto/modbus.md describes the format and the profiles that "
      "come with Tactor. The line runs on its own thread, at the rate that it can carry, and the device loop takes the "
      "newest sample with its age. A device with one axis moves along one direction of the scene; set that direction "
      "by rotation.");
  declaration
      .file("profile", &Params::profile, true, "the profile: the path of a file, or a shipped one such as iris_orca",
            profiles_of("modbus"))
      .text("connect", &Params::connect, std::nullopt, "tcp:HOST:PORT or rtu:PATH of the serial port")
      .integer<std::int32_t>("unit", &Params::unit,
                             {.doc = "slave id; 0: as in the profile", .default_value = 0, .min = 0, .max = 247})
      .integer<std::int32_t>(
          "baud", &Params::baud,
          {.doc = "baud rate of the serial line; 0: as in the profile", .default_value = 0, .min = 0, .max = 4'000'000})
      .real("link_rate", &Params::link_rate,
            {.doc = "cycles of the line per second; 0: the same as rate, but at most 95 % of what the line can carry",
             .unit = "Hz",
             .default_value = 0,
             .min = 0,
             .max = 1e4})
      .real("response_timeout", &Params::response_timeout,
            {.doc = "longest time to wait for one answer; 0: as in the profile",
             .unit = "s",
             .default_value = 0,
             .min = 0,
             .max = 5});
  declare_hardware(declaration, defaults);
  declaration.discover(discover).calibrate(calibrate);
  return declaration.info();
}

}  // namespace tactor::modbus
