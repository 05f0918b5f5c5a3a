// Messages from the columns of a CSV file, by a mapping of their fields.
#pragma once

#include <string>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"
#include "nodes/source/csv_table.hpp"

namespace tactor {

/// What a mapping makes of a file; a list is empty where none of its fields is mapped.
struct MappedMessages {
  std::vector<Stamped<Wrench>> force;
  std::vector<Stamped<DeviceState>> device;
  std::vector<Stamped<Target>> target;
};

/// Makes messages from a table. A mapping pairs a field with `heading [unit]`, then any number of ` * quantity` and
/// ` / quantity`, for example `force.x: minus_Fh_Nm [N m] * -1 / 0.075 m`; without `[unit]` the heading's own unit
/// holds.
///
/// Fields: time (s, must be there); force.x .y .z (N) and torque.x .y .z (N m) make `force`; position (m), rotation
/// (rad, a rotation vector), velocity (m/s) and angular_velocity (rad/s), each .x .y .z, make `device` and `target`.
/// What is not mapped is 0. Where a row of velocity or angular velocity is not mapped at all, it is the central
/// difference (x_{i+1} - x_{i-1}) / (t_{i+1} - t_{i-1}), one-sided at the ends.
///
/// Throws InputError naming `where`, the field and what is expected: unknown fields and columns, units that do not come
/// out as the field's, times that do not increase (with file and line).
MappedMessages map_columns(const CsvTable& table, const Mapping& mapping, const std::string& where);

}  // namespace tactor
