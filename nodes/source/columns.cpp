#include "nodes/source/columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "framework/core/check.hpp"
#include "framework/core/text.hpp"
#include "framework/core/units.hpp"

namespace tactor {

namespace {

struct Group {
  std::string_view name;
  std::string_view unit;
};

constexpr std::array<Group, 6> groups{{{"force", "N"},
                                       {"torque", "N m"},
                                       {"position", "m"},
                                       {"rotation", "rad"},
                                       {"velocity", "m/s"},
                                       {"angular_velocity", "rad/s"}}};
enum GroupIndex : std::size_t { force, torque, position, rotation, velocity, angular_velocity };

void multiply(Quantity& by, const Quantity& factor, bool divide) {
  by.value_si = divide ? by.value_si / factor.value_si : by.value_si * factor.value_si;
  const auto add = [divide](std::int8_t a, std::int8_t b) { return static_cast<std::int8_t>(divide ? a - b : a + b); };
  by.dimension = {.m = add(by.dimension.m, factor.dimension.m),
                  .kg = add(by.dimension.kg, factor.dimension.kg),
                  .s = add(by.dimension.s, factor.dimension.s),
                  .A = add(by.dimension.A, factor.dimension.A),
                  .K = add(by.dimension.K, factor.dimension.K)};
}

/// A column and what its numbers are multiplied by to be SI.
struct Source {
  std::size_t column;
  double factor;
};

Source parse_source(const CsvTable& table, std::string_view text, std::string_view unit, const std::string& where) {
  // The operators stand between spaces, so that units keep theirs.
  const std::size_t bracket = text.find(']');
  const std::size_t from = bracket == std::string_view::npos ? 0 : bracket;
  const std::size_t end = std::min(text.find(" * ", from), text.find(" / ", from));
  std::string_view heading = trimmed(text.substr(0, end));
  std::optional<std::size_t> column = table.find(heading);
  std::optional<Unit> column_unit;
  if (column) column_unit = table.columns[*column].unit;
  if (const std::size_t open = heading.rfind('['); open != std::string_view::npos && heading.back() == ']') {
    const std::string_view unit_text = heading.substr(open + 1, heading.size() - open - 2);
    column_unit = parse_unit(unit_text);
    if (!column_unit) throw InputError(where + ": [" + std::string(unit_text) + "] is not a unit");
    if (!column) column = table.find(trimmed(heading.substr(0, open)));
  }
  if (!column) {
    std::string there;
    for (const CsvColumn& c : table.columns) there.append(there.empty() ? "" : ", ").append(c.heading);
    throw InputError(where + ": " + table.path.string() + " has no column '" + std::string(heading) +
                     "'; it has: " + there);
  }
  if (!column_unit) {
    throw InputError(where + ": the heading '" + std::string(heading) + "' names no unit; write it as `" +
                     std::string(heading) + " [unit]`");
  }
  Quantity factor{column_unit->scale, column_unit->dimension};
  std::string_view rest = end == std::string_view::npos ? std::string_view() : text.substr(end);
  while (!rest.empty()) {
    const bool divide = rest[1] == '/';
    rest.remove_prefix(3);
    const std::size_t next = std::min(rest.find(" * "), rest.find(" / "));
    const auto quantity = parse_quantity(rest.substr(0, next));
    if (const auto* error = std::get_if<std::string>(&quantity)) throw InputError(where + ": " + *error);
    const Quantity& by = std::get<Quantity>(quantity);
    if (by.value_si == 0) throw InputError(where + ": a factor of 0 leaves nothing of the column");
    multiply(factor, by, divide);
    rest = next == std::string_view::npos ? std::string_view() : rest.substr(next);
  }
  if (factor.dimension != parse_unit(unit)->dimension) {
    throw InputError(where + ": the column comes out in " + describe(factor.dimension) + ", expected " +
                     std::string(unit) + "; give the factor its unit, for example `tau_Nm / 0.075 m`");
  }
  return {*column, factor.value_si};
}

struct Fields {
  std::optional<Source> time;
  std::array<std::array<std::optional<Source>, 3>, groups.size()> of;

  [[nodiscard]] bool any(GroupIndex group) const {
    return std::any_of(of[group].begin(), of[group].end(), [](const auto& source) { return source.has_value(); });
  }
  [[nodiscard]] Vec3 read(const CsvTable& table, std::size_t row, GroupIndex group) const {
    Vec3 value;
    for (int axis = 0; axis < 3; ++axis) {
      const std::optional<Source>& source = of[group][static_cast<std::size_t>(axis)];
      if (source) value[axis] = source->factor * table.at(row, source->column);
    }
    return value;
  }
};

std::optional<Source>* find_field(Fields& fields, std::string_view name) {
  if (name == "time") return &fields.time;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string field = std::string(groups[g].name).append(1, '.').append(1, "xyz"[axis]);
      if (name == field) return &fields.of[g][axis];
    }
  }
  return nullptr;
}

Fields parse_mapping(const CsvTable& table, const Mapping& mapping, const std::string& where) {
  Fields fields;
  for (const auto& [name, text] : mapping) {
    const std::string place = where + ": " + name;
    std::optional<Source>* field = find_field(fields, name);
    if (field == nullptr) {
      throw InputError(place +
                       " is not a field; expected time, or one of force, torque, position, rotation, velocity, "
                       "angular_velocity with .x, .y or .z");
    }
    if (*field) throw InputError(place + " is mapped twice");
    const std::string_view group = std::string_view(name).substr(0, name.find('.'));
    std::string_view unit = "s";
    for (const Group& g : groups) {
      if (g.name == group) unit = g.unit;
    }
    *field = parse_source(table, text, unit, place);
  }
  if (!fields.time) throw InputError(where + ": the field time is not mapped, for example `time: t_s`");
  if (mapping.size() < 2) throw InputError(where + ": only time is mapped; map the fields of a message as well");
  return fields;
}

std::vector<Stamp> read_stamps(const CsvTable& table, const Source& source) {
  std::vector<Stamp> stamps(table.rows());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double t = source.factor * table.at(i, source.column);
    if (std::abs(t) > 1e9) throw InputError(table.place(i) + ": a time of " + std::to_string(t) + " s is out of range");
    stamps[i] = {Time::from_seconds(t), Time::from_seconds(t), i};
    if (i > 0 && stamps[i].valid <= stamps[i - 1].valid)
      throw InputError(table.place(i) + ": the time does not increase");
  }
  return stamps;
}

}  // namespace

MappedMessages map_columns(const CsvTable& table, const Mapping& mapping, const std::string& where) {
  const Fields fields = parse_mapping(table, mapping, where);
  const std::vector<Stamp> stamps = read_stamps(table, *fields.time);
  MappedMessages messages;
  if (fields.any(force) || fields.any(torque)) {
    messages.force.reserve(stamps.size());
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      messages.force.push_back({stamps[i], {fields.read(table, i, force), fields.read(table, i, torque)}});
    }
  }
  const bool moves =
      fields.any(position) || fields.any(rotation) || fields.any(velocity) || fields.any(angular_velocity);
  if (!moves) return messages;
  messages.target.reserve(stamps.size());
  messages.device.reserve(stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    Target target;
    target.X_WH = {fields.read(table, i, position), from_rotation_vector(fields.read(table, i, rotation))};
    messages.target.push_back({stamps[i], target});
  }
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const Stamped<Target>& before = messages.target[i == 0 ? 0 : i - 1];
    const Stamped<Target>& after = messages.target[std::min(i + 1, stamps.size() - 1)];
    const double span = std::max((after.stamp.valid - before.stamp.valid).seconds(), 1e-9);
    Target& target = messages.target[i].value;
    target.V_WH.v =
        fields.any(velocity) ? fields.read(table, i, velocity) : (after.value.X_WH.p - before.value.X_WH.p) / span;
    target.V_WH.w = fields.any(angular_velocity)
                        ? fields.read(table, i, angular_velocity)
                        : to_rotation_vector(after.value.X_WH.R * inverse(before.value.X_WH.R)) / span;
    DeviceState device;
    device.X_WD = target.X_WH;
    device.V_WD = target.V_WH;
    messages.device.push_back({stamps[i], device});
  }
  return messages;
}

}  // namespace tactor
