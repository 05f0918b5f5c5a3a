#include "devices/modbus/emulator/faults.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "framework/core/check.hpp"

namespace tactor::modbus {

namespace {

constexpr std::array<std::string_view, 14> names{"silent",    "slow",  "dribble", "late", "crc",   "slave",  "length",
                                                 "exception", "reset", "another", "jump", "stuck", "unplug", "status"};

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::string_view name_of(FaultKind kind) {
  return names[static_cast<std::size_t>(kind)];
}

Fault parse_fault(const std::string& text) {
  const auto refuse = [&]() -> InputError {
    std::string kinds;
    for (const std::string_view name : names) kinds.append(kinds.empty() ? "" : ", ").append(name);
    return InputError("fault: expected KIND[@TIME or @driven+TIME][:VALUE] with a KIND of " + kinds + ", found \"" +
                      text + "\"");
  };
  Fault fault;
  std::string_view rest = text;
  if (const std::size_t colon = rest.find(':'); colon != std::string_view::npos) {
    const auto value = number(rest.substr(colon + 1));
    if (!value || std::abs(*value) > 1e6) throw refuse();
    fault.value = *value;
    rest = rest.substr(0, colon);
  }
  if (const std::size_t at = rest.find('@'); at != std::string_view::npos) {
    std::string_view when = rest.substr(at + 1);
    if (when.starts_with("driven+")) {
      fault.when_driven = true;
      when.remove_prefix(7);
    }
    const auto time = number(when);
    if (!time || *time < 0) throw refuse();
    fault.time = *time;
    rest = rest.substr(0, at);
  }
  const auto found = std::find(names.begin(), names.end(), rest);
  if (found == names.end()) throw refuse();
  fault.kind = static_cast<FaultKind>(found - names.begin());
  return fault;
}

}  // namespace tactor::modbus
