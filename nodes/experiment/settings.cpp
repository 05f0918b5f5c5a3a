#include "nodes/experiment/settings.hpp"

#include <algorithm>
#include <string_view>

#include "framework/core/text.hpp"
#include "framework/core/units.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/experiment/number_text.hpp"
#include "nodes/experiment/protocol.hpp"

namespace tactor {

namespace {

/// The least and the largest level that can come up, or all of them.
std::vector<double> possible_levels(const Protocol::Params& params) {
  if (params.procedure == Procedure::constant) return params.levels;
  return {params.least, params.most};
}

Setting setting_of(std::string path, std::string_view text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  return {std::move(path), std::string(trimmed(text.substr(0, equals))),
          std::string(text.substr(std::min(equals + 1, text.size())))};
}

void add_condition(ProtocolSettings& settings, const std::string& path, std::string_view text) {
  ProtocolSettings::Range range{settings.list.size(), 0};
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(';', begin), text.size());
    const std::string_view one = trimmed(text.substr(begin, end - begin));
    if (!one.empty()) settings.list.push_back(setting_of(path, one));
    begin = end + 1;
  }
  range.end = settings.list.size();
  settings.conditions.push_back(range);
}

}  // namespace

bool Protocol::has_level(const Params& params) {
  return params.procedure != Procedure::pairs;
}

double Protocol::level_si(const Params& params, double level) {
  const auto read = parse_quantity(level_text(params, level));
  if (const auto* problem = std::get_if<std::string>(&read)) throw ValueError("unit", "unit: " + *problem);
  return std::get<Quantity>(read).value_si;
}

std::string Protocol::level_text(const Params& params, double level) {
  return shortest(params.standard + level) + (params.unit.empty() ? "" : " " + params.unit);
}

ProtocolSettings Protocol::settings(const Params& params) {
  ProtocolSettings settings;
  for (const auto& [code, text] : params.conditions) add_condition(settings, "conditions." + code, text);
  if (settings.conditions.empty()) settings.conditions.emplace_back();
  const auto add = [&](std::string path, std::string parameter, std::string value) {
    settings.list.push_back({std::move(path), std::move(parameter), std::move(value)});
    return settings.list.size() - 1;
  };
  settings.muted = add("mute", params.mute, "0");
  if (!has_level(params) || params.level != params.mute) settings.unmuted = add("mute", params.mute, "1");
  if (!has_level(params)) return settings;
  settings.level = add("standard", params.level, level_text(params, 0));
  for (const double level : possible_levels(params)) add("level", params.level, level_text(params, level));
  return settings;
}

}  // namespace tactor
