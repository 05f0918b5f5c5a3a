#include "devices/modbus/actuator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "devices/hardware/declare_hardware.hpp"
#include "devices/modbus/serial_ports.hpp"
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

HardwareParts make_parts(const Actuator::Params& params) {
  Setup setup = make_setup(params);
  HardwareParts parts;
  std::vector<Vec3> directions;
  double finest = 1;
  for (std::size_t i = 0; i < setup.profile.axes.size(); ++i) {
    const Axis& axis = setup.profile.axes[i];
    directions.push_back(axis.direction);
    parts.limits.effort_max[i] = axis.effort_max;
    parts.limits.speed_max[i] = axis.speed_max;
    parts.limits.jump_tolerance[i] = axis.jump_tolerance;
    finest = std::min(finest, std::abs(setup.profile.registers[axis.position].scale));
  }
  parts.limits.axes = static_cast<int>(setup.profile.axes.size());
  parts.resolution = finest;
  parts.kinematics = std::make_unique<LinearKinematics>(directions);
  parts.rate = setup.rate;
  parts.link = std::make_unique<ModbusLink>(std::move(setup.profile), std::move(setup.endpoint));
  return parts;
}

std::string calibrate(const Actuator::Params& params, const Ask& ask) {
  const Setup setup = make_setup(params);
  if (setup.profile.calibrate.empty()) return setup.profile.name + " needs no calibration";
  ModbusLink link(setup.profile, setup.endpoint);
  if (!ask(link.name() + ": put it where its zero is to be and let it rest. It may move. Go on?"))
    return "nothing done";
  LinkFailure failure;
  if (!link.open(failure) || !link.calibrate(failure)) throw RunError(link.name() + ": " + failure.text);
  link.close();
  return link.name() + ": calibrated";
}

}  // namespace

Setup make_setup(const Actuator::Params& params) {
  Setup setup{read_profile(params.profile), parse_endpoint(params.connect), 0, {}};
  LineSettings& line = setup.profile.line;
  if (params.unit > 0) line.unit = params.unit;
  if (params.baud > 0) line.baud = params.baud;
  if (params.response_timeout.ns > 0) line.response_timeout = params.response_timeout;
  setup.line = line_rate(plan_cycle(setup.profile), line, setup.endpoint.serial);
  setup.rate = params.link_rate > 0 ? params.link_rate : std::min(params.rate, share_of_line * setup.line.rate);
  if (setup.rate > setup.line.rate) {
    std::string how = text_of("at most %.6g Hz; a cycle takes %.3g ms", setup.line.rate, 1e3 * setup.line.cycle_s);
    if (setup.endpoint.serial) {
      how += " at " + std::to_string(line.baud) + " baud with " + std::to_string(line.character_bits()) +
             " bits a character";
    }
    throw InputError("link_rate: expected what the line of " + setup.profile.name + " can carry, " + how + ", found " +
                     text_of("%.6g Hz", params.link_rate));
  }
  // A sample must come before it is too old to be used.
  if (1 / setup.rate > params.link_timeout.seconds()) {
    throw InputError("link_timeout: expected at least a cycle of the line, " + text_of("%.3g ms", 1e3 / setup.rate) +
                     ", found " + text_of("%.3g ms", 1e3 * params.link_timeout.seconds()));
  }
  return setup;
}

Actuator::Actuator(const Params& params, const NodeContext& context)
    : HardwareDevice(params, context, make_parts(params)) {}

NodeInfo Actuator::declare() {
  Declare<Actuator> declaration("modbus.actuator", "A real actuator on Modbus, TCP or a serial line.");
  HardwareParams defaults;
  defaults.failure_timeout = Duration{5'000'000'000};
  declaration.details(
      "A profile says what registers the device has; docs/modbus.md has the format and those that come with Tactor. "
      "Its "
      "line runs on a thread of its own, at the rate that the line can carry, and the device loop takes the newest "
      "sample "
      "with its age. A device of one axis moves along one direction of the scene; turn it there by rotation.");
  declaration.file("profile", &Params::profile, true, "the profile, such as modbus/iris_orca.yaml")
      .text("connect", &Params::connect, std::nullopt, "tcp:HOST:PORT or rtu:PATH of the serial port")
      .integer<std::int32_t>("unit", &Params::unit,
                             {.doc = "slave id; 0: that of the profile", .default_value = 0, .min = 0, .max = 247})
      .integer<std::int32_t>(
          "baud", &Params::baud,
          {.doc = "of the serial line; 0: that of the profile", .default_value = 0, .min = 0, .max = 4'000'000})
      .real("link_rate", &Params::link_rate,
            {.doc = "cycles of the line; 0: rate, and at most 95 % of what the line can carry",
             .unit = "Hz",
             .default_value = 0,
             .min = 0,
             .max = 1e4})
      .real("response_timeout", &Params::response_timeout,
            {.doc = "of one answer; 0: that of the profile", .unit = "s", .default_value = 0, .min = 0, .max = 5});
  declare_hardware(declaration, defaults);
  declaration.check_params([](const Params& params) { static_cast<void>(make_setup(params)); })
      .discover([] { return serial_ports(); })
      .calibrate(calibrate);
  return declaration.info();
}

}  // namespace tactor::modbus
