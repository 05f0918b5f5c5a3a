#include "devices/usb/profile.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "devices/hardware/profile_files.hpp"
#include "devices/usb/wooden_kinematics.hpp"
#include "framework/core/check.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

constexpr std::size_t largest_report = 512;
const std::map<std::string, FieldType> field_types{
    {"uint8", FieldType::u8},   {"int8", FieldType::i8},   {"uint16", FieldType::u16}, {"int16", FieldType::i16},
    {"uint32", FieldType::u32}, {"int32", FieldType::i32}, {"float32", FieldType::f32}};

/// Reads one profile; what it reads of a broken one is never used.
class Reader {
 public:
  Reader(UsbProfile& profile, Diagnostics& diagnostics) : p_(profile), d_(diagnostics) {}

  void read(const Tree& tree) {
    if (!map_of(tree, "profile",
                {"title", "usb", "report", "command", "axes", "buttons", "faults", "kinematics", "calibration",
                 "resolution", "emulator"})) {
      return;
    }
    if (const Tree* t = need(tree, "profile", "title")) p_.title = read_text(*t, "title", d_).value_or("");
    if (const Tree* t = need(tree, "profile", "usb")) read_usb(*t);
    if (const Tree* t = need(tree, "profile", "kinematics")) read_kinematics(*t);
    if (const Tree* t = need(tree, "profile", "report")) read_report(*t);
    if (const Tree* t = need(tree, "profile", "command")) read_command(*t);
    if (const Tree* t = need(tree, "profile", "axes")) read_axes(*t);
    if (const Tree* t = tree.value("buttons")) read_flags(*t, "buttons", p_.input.buttons, false);
    if (const Tree* t = tree.value("faults")) read_flags(*t, "faults", p_.input.faults, true);
    if (const Tree* t = tree.value("calibration")) p_.calibration = read_text(*t, "calibration", d_).value_or("");
    if (const Tree* t = tree.value("resolution")) number(*t, "resolution", {"m", 0, 1, true}, p_.resolution);
    if (const Tree* t = tree.value("emulator")) read_emulation(*t);
  }

 private:
  bool map_of(const Tree& tree, const std::string& path, const std::vector<std::string>& keys) {
    if (!expect_map(tree, path, "a map of " + list_of(keys), d_)) return false;
    check_keys(tree, path, "key", keys, d_);
    return true;
  }
  const Tree* need(const Tree& map, const std::string& path, std::string_view key) {
    const Tree* value = map.value(key);
    if (value == nullptr) {
      d_.error(map.place, path + ": expected " + std::string(key) + ", found none");
    }
    return value;
  }
  bool number(const Tree& tree, const std::string& path, const NumberRule& rule, double& value) {
    const auto got = read_number(tree, path, rule, d_);
    if (got) value = *got;
    return got.has_value();
  }
  /// A whole number, decimal or 0x..., from `min` to `max`.
  std::int64_t numeral(const Tree& tree, const std::string& path, std::int64_t min, std::int64_t max) {
    std::string_view text = tree.text;
    const bool hex = text.starts_with("0x") || text.starts_with("0X");
    if (hex) text.remove_prefix(2);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, hex ? 16 : 10);
    const bool good = tree.is_scalar() && !text.empty() && error == std::errc{} && end == text.data() + text.size() &&
                      text.front() != '-' && (hex || text.size() == 1 || text.front() != '0') && value >= min &&
                      value <= max;
    if (good) return value;
    char bounds[64];
    std::snprintf(bounds, sizeof bounds, "%lld to %lld (0x%llx)", static_cast<long long>(min),
                  static_cast<long long>(max), static_cast<unsigned long long>(max));
    d_.error(tree.place, path + ": expected a whole number from " + bounds + ", found " + describe(tree));
    return min;
  }
  void numeral_at(const Tree& map, const std::string& path, std::string_view key, std::int64_t min, std::int64_t max,
                  std::int64_t& value) {
    if (const Tree* t = map.value(key)) value = numeral(*t, path + "." + std::string(key), min, max);
  }

  void read_usb(const Tree& tree) {
    if (!map_of(tree, "usb",
                {"vendor", "product", "product_text", "transfer", "interface", "endpoints", "rate", "report_timeout",
                 "asks_first"})) {
      return;
    }
    if (const Tree* t = need(tree, "usb", "vendor")) {
      p_.vendor = static_cast<std::uint16_t>(numeral(*t, "usb.vendor", 0, 0xffff));
    }
    if (const Tree* t = need(tree, "usb", "product")) {
      p_.product = static_cast<std::uint16_t>(numeral(*t, "usb.product", 0, 0xffff));
    }
    if (const Tree* t = tree.value("product_text"))
      p_.product_text = read_text(*t, "usb.product_text", d_).value_or("");
    if (const Tree* t = need(tree, "usb", "transfer")) {
      const auto kind = read_choice(*t, "usb.transfer", {"interrupt", "bulk"}, d_);
      p_.transfers.kind = kind == "bulk" ? UsbTransfers::Kind::bulk : UsbTransfers::Kind::interrupt;
    }
    std::int64_t interface = 0;
    numeral_at(tree, "usb", "interface", 0, 255, interface);
    p_.transfers.interface = static_cast<int>(interface);
    if (const Tree* t = tree.value("endpoints"); t != nullptr && map_of(*t, "usb.endpoints", {"in", "out"})) {
      std::int64_t in = 0, out = 0;
      numeral_at(*t, "usb.endpoints", "in", 0x81, 0x8f, in);
      numeral_at(*t, "usb.endpoints", "out", 0x01, 0x0f, out);
      p_.transfers.in = static_cast<std::uint8_t>(in);
      p_.transfers.out = static_cast<std::uint8_t>(out);
    }
    if (const Tree* t = need(tree, "usb", "rate")) number(*t, "usb.rate", {"Hz", 1, 8000}, p_.rate);
    double timeout = p_.report_timeout.seconds();
    if (const Tree* t = tree.value("report_timeout")) number(*t, "usb.report_timeout", {"s", 1e-3, 1}, timeout);
    p_.report_timeout = Duration::from_seconds(timeout);
    if (const Tree* t = tree.value("asks_first"))
      p_.asks_first = read_boolean(*t, "usb.asks_first", d_).value_or(false);
  }

  void read_fields(const Tree& tree, const std::string& path, std::size_t size, std::vector<ReportField>& fields) {
    if (!expect_map(tree, path, "a map of fields by their names", d_)) return;
    for (const TreeEntry& entry : tree.entries) {
      const std::string at = path + "." + entry.key;
      ReportField field;
      field.name = entry.key;
      if (!map_of(entry.value, at, {"at", "type", "order"})) continue;
      std::int64_t place = 0;
      if (need(entry.value, at, "at") != nullptr) {
        numeral_at(entry.value, at, "at", 0, static_cast<std::int64_t>(largest_report) - 1, place);
      }
      field.at = static_cast<std::size_t>(place);
      if (const Tree* t = need(entry.value, at, "type")) {
        std::vector<std::string> names;
        for (const auto& [name, type] : field_types) names.push_back(name);
        const auto type = read_choice(*t, at + ".type", names, d_);
        if (type) field.type = field_types.at(*type);
      }
      if (const Tree* t = entry.value.value("order")) {
        if (read_choice(*t, at + ".order", {"little", "big"}, d_) == "big") field.order = ByteOrder::big;
      }
      if (field.at + field.size() > size) {
        d_.error(entry.value.place, at + ": expected a field within the " + std::to_string(size) +
                                        " bytes of the report, found one of bytes " + std::to_string(field.at) +
                                        " to " + std::to_string(field.at + field.size() - 1));
      }
      fields.push_back(field);
    }
  }

  std::size_t read_size(const Tree& tree, const std::string& path) {
    const Tree* t = need(tree, path, "size");
    return t == nullptr ? 1 : static_cast<std::size_t>(numeral(*t, path + ".size", 1, largest_report));
  }

  void read_report(const Tree& tree) {
    if (!map_of(tree, "report", {"size", "fields"})) return;
    p_.input.size = read_size(tree, "report");
    if (const Tree* t = need(tree, "report", "fields")) {
      read_fields(*t, "report.fields", p_.input.size, p_.input.fields);
    }
  }

  void read_command(const Tree& tree) {
    if (!map_of(tree, "command", {"size", "fields", "fixed"})) return;
    p_.output.size = read_size(tree, "command");
    if (const Tree* t = need(tree, "command", "fields")) {
      read_fields(*t, "command.fields", p_.output.size, p_.output.fields);
    }
    const Tree* fixed = tree.value("fixed");
    if (fixed == nullptr || !expect_map(*fixed, "command.fixed", "a map of values by fields", d_)) return;
    for (const TreeEntry& entry : fixed->entries) {
      const std::string path = "command.fixed." + entry.key;
      const std::size_t field = index_of(entry.key, entry.place, path, p_.output.fields);
      if (field >= p_.output.fields.size()) continue;
      const ReportField& f = p_.output.fields[field];
      FixedOutput output{field, 0};
      number(entry.value, path, {"1", f.least(), f.most()}, output.value);
      p_.output.fixed.push_back(output);
    }
  }

  std::size_t index_of(const std::string& name, const SourceLocation& place, const std::string& path,
                       const std::vector<ReportField>& fields) {
    std::vector<std::string> names;
    for (const ReportField& field : fields) names.push_back(field.name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    d_.error(place, path + ": expected one of the fields (" + list_of(names) + "), found \"" + name + "\"" +
                        did_you_mean(name, names));
    return fields.size();
  }
  std::size_t field_at(const Tree& map, const std::string& path, std::string_view key,
                       const std::vector<ReportField>& fields) {
    const Tree* t = need(map, path, key);
    if (t == nullptr) return fields.size();
    const auto name = read_text(*t, path + "." + std::string(key), d_);
    return name ? index_of(*name, t->place, path + "." + std::string(key), fields) : fields.size();
  }

  void read_axes(const Tree& tree) {
    const std::string wanted = std::to_string(axes_);
    if (!tree.is_sequence() || tree.items.size() != axes_) {
      d_.error(tree.place, "axes: expected a list of the " + wanted + " axes of its kinematics, found " +
                               (tree.is_sequence() ? std::to_string(tree.items.size()) : describe(tree)));
      return;
    }
    std::set<std::size_t> used_in, used_out;
    for (std::size_t i = 0; i < tree.items.size(); ++i) {
      read_axis(tree.items[i], "axes[" + std::to_string(i) + "]", used_in, used_out);
    }
  }

  void read_axis(const Tree& tree, const std::string& path, std::set<std::size_t>& used_in,
                 std::set<std::size_t>& used_out) {
    if (!map_of(
            tree, path,
            {"name", "position", "step", "at_zero", "effort", "effort_step", "limit", "speed_max", "jump_tolerance"})) {
      return;
    }
    const std::string length = slides_ ? "m" : "rad", effort = slides_ ? "N" : "N m", speed = slides_ ? "m/s" : "rad/s";
    UsbAxis axis;
    AxisInput in;
    AxisOutput out;
    if (const Tree* t = need(tree, path, "name")) axis.name = read_text(*t, path + ".name", d_).value_or("");
    in.field = field_at(tree, path, "position", p_.input.fields);
    if (in.field < p_.input.fields.size() && !used_in.insert(in.field).second) {
      d_.error(tree.place, path + ".position: expected a field of its own, found one of another axis");
    }
    if (const Tree* t = need(tree, path, "step")) {
      number(*t, path + ".step", {length}, in.scale);
      not_zero(*t, path + ".step", in.scale);
    }
    if (const Tree* t = tree.value("at_zero")) number(*t, path + ".at_zero", {length}, in.offset);
    out.field = field_at(tree, path, "effort", p_.output.fields);
    if (out.field < p_.output.fields.size() && !used_out.insert(out.field).second) {
      d_.error(tree.place, path + ".effort: expected a field of its own, found one of another axis");
    }
    double step = 1;
    if (const Tree* t = need(tree, path, "effort_step")) {
      number(*t, path + ".effort_step", {effort}, step);
      not_zero(*t, path + ".effort_step", step);
    }
    out.scale = 1 / step;
    if (const Tree* t = need(tree, path, "limit")) number(*t, path + ".limit", {"1", 0, 4.3e9, true}, out.limit);
    if (const Tree* t = need(tree, path, "speed_max")) {
      number(*t, path + ".speed_max", {speed, 0, 1e4, true}, axis.speed_max);
    }
    if (const Tree* t = need(tree, path, "jump_tolerance")) {
      number(*t, path + ".jump_tolerance", {length, 0, 1e3}, axis.jump_tolerance);
    }
    axis.effort_max = out.limit * std::abs(step);
    p_.axes.push_back(axis);
    p_.input.axes.push_back(in);
    p_.output.axes.push_back(out);
  }

  void not_zero(const Tree& tree, const std::string& path, double value) {
    if (value == 0) d_.error(tree.place, path + ": expected a value other than 0, found " + describe(tree));
  }

  void read_flags(const Tree& tree, const std::string& path, std::vector<Flag>& flags, bool meanings) {
    if (!tree.is_sequence() || tree.items.size() > 32) {
      d_.error(tree.place, path + ": expected a list of at most 32, found " + describe(tree));
      return;
    }
    for (std::size_t i = 0; i < tree.items.size(); ++i) {
      const Tree& item = tree.items[i];
      const std::string at = path + "[" + std::to_string(i) + "]";
      std::vector<std::string> keys{"field", "bit", "above"};
      if (meanings) keys.emplace_back("meaning");
      if (!map_of(item, at, keys)) continue;
      Flag flag;
      flag.field = field_at(item, at, "field", p_.input.fields);
      const bool known = flag.field < p_.input.fields.size();
      const bool has_bit = item.value("bit") != nullptr, has_above = item.value("above") != nullptr;
      if (has_bit == has_above) d_.error(item.place, at + ": expected one of bit and above");
      std::int64_t bit = -1;
      if (has_bit) {
        const std::size_t bits = known ? 8 * p_.input.fields[flag.field].size() : 32;
        numeral_at(item, at, "bit", 0, static_cast<std::int64_t>(bits) - 1, bit);
        if (known && !p_.input.fields[flag.field].is_whole()) {
          d_.error(item.place, at + ": expected a field of whole numbers, found one of float32, which has no bits");
        }
      }
      flag.bit = static_cast<int>(bit);
      if (has_above) number(*item.value("above"), at + ".above", {}, flag.above);
      if (meanings) {
        if (const Tree* t = need(item, at, "meaning")) flag.meaning = read_text(*t, at + ".meaning", d_).value_or("");
      }
      flags.push_back(flag);
    }
  }

  void read_kinematics(const Tree& tree) {
    if (!expect_map(tree, "kinematics", "a map with a type", d_)) return;
    const Tree* type = need(tree, "kinematics", "type");
    const auto name = type == nullptr ? std::nullopt : read_choice(*type, "kinematics.type", {"linear", "wooden"}, d_);
    if (!name) return;
    p_.kinematics = *name;
    slides_ = *name == "linear";
    if (slides_) {
      if (!map_of(tree, "kinematics", {"type", "directions"})) return;
      if (const Tree* t = need(tree, "kinematics", "directions")) read_directions(*t);
      return;
    }
    axes_ = 3;
    if (!map_of(tree, "kinematics", {"type", "lengths", "center"})) return;
    for (const auto& [key, rule] :
         {std::pair<const char*, NumberRule>{"lengths", {"m", 0, 10, true}}, {"center", {"m", -10, 10}}}) {
      const Tree* t = need(tree, "kinematics", key);
      if (t == nullptr) continue;
      const auto three = read_numbers(*t, std::string("kinematics.") + key, 3, rule, d_);
      if (three) p_.numbers.insert(p_.numbers.end(), three->begin(), three->end());
    }
  }

  void read_directions(const Tree& tree) {
    if (!tree.is_sequence() || tree.items.empty() || tree.items.size() > 3) {
      d_.error(tree.place, "kinematics.directions: expected a list of 1 to 3 directions, found " + describe(tree));
      return;
    }
    axes_ = tree.items.size();
    std::vector<Vec3> directions;
    for (std::size_t i = 0; i < tree.items.size(); ++i) {
      const auto three = read_numbers(tree.items[i], "kinematics.directions[" + std::to_string(i) + "]", 3, {}, d_);
      if (!three) return;
      p_.numbers.insert(p_.numbers.end(), three->begin(), three->end());
      directions.push_back({(*three)[0], (*three)[1], (*three)[2]});
    }
    try {
      const LinearKinematics linear(directions);
    } catch (const InputError& error) {
      d_.error(tree.place, std::string("kinematics.directions: ") + error.what());
    }
  }

  void read_emulation(const Tree& tree) {
    UsbEmulation& e = p_.emulation;
    if (!map_of(tree, "emulator",
                {"mass", "damping", "stiffness", "friction", "hold", "approach", "watchdog", "start", "path"})) {
      return;
    }
    const auto real = [&](const char* key, const char* unit, double min, double max, double& value) {
      if (const Tree* t = tree.value(key)) number(*t, std::string("emulator.") + key, {unit, min, max}, value);
    };
    real("mass", "kg", 1e-3, 100, e.mass);
    real("damping", "N s/m", 0, 1e3, e.damping);
    real("stiffness", "N/m", 0, 1e5, e.stiffness);
    real("friction", "N s/m", 0, 1e3, e.friction);
    real("hold", "s", 0, 1e3, e.hold);
    real("approach", "s", 1e-3, 1e3, e.approach);
    real("watchdog", "s", 1e-3, 1e3, e.watchdog);
    if (const Tree* t = tree.value("start")) {
      e.start = read_numbers(*t, "emulator.start", 3, {"m", -10, 10}, d_).value_or(e.start);
    }
    const Tree* path = tree.value("path");
    if (path == nullptr) return;
    if (!path->is_sequence() || path->items.empty()) {
      d_.error(path->place, "emulator.path: expected a list of [t, x, y, z], found " + describe(*path));
      return;
    }
    for (std::size_t i = 0; i < path->items.size(); ++i) {
      const Tree& item = path->items[i];
      const std::string at = "emulator.path[" + std::to_string(i) + "]";
      double values[4] = {0, 0, 0, 0};
      if (!item.is_sequence() || item.items.size() != 4) {
        d_.error(item.place, at + ": expected [t, x, y, z], found " + describe(item));
        continue;
      }
      for (std::size_t n = 0; n < 4; ++n) {
        const NumberRule rule = n == 0 ? NumberRule{"s", 0, 1e4} : NumberRule{"m", -10, 10};
        number(item.items[n], at + "[" + std::to_string(n) + "]", rule, values[n]);
      }
      if (!e.times.empty() && values[0] <= e.times.back()) {
        d_.error(item.place, at + ": expected a time after the one before, found " + describe(item.items[0]));
      }
      e.times.push_back(values[0]);
      e.points.push_back({values[1], values[2], values[3]});
    }
  }

  UsbProfile& p_;
  Diagnostics& d_;
  std::size_t axes_ = 1;
  bool slides_ = true;
};

UsbProfile checked(const std::optional<Tree>& tree, const std::filesystem::path& file, Diagnostics& diagnostics) {
  UsbProfile profile;
  profile.name = file.stem().string();
  if (tree && !tree->is_null()) {
    Reader(profile, diagnostics).read(*tree);
  } else if (!diagnostics.any()) {
    diagnostics.error({file.string(), 1, 1}, "expected a profile of a USB device, found nothing");
  }
  diagnostics.throw_if_any();
  profile.transfers.in_size = profile.input.size;
  profile.transfers.out_size = profile.output.size;
  return profile;
}

}  // namespace

std::unique_ptr<Kinematics> UsbProfile::make_kinematics() const {
  if (kinematics == "wooden") {
    return std::make_unique<WoodenKinematics>(
        WoodenGeometry{numbers[0], numbers[1], numbers[2], {numbers[3], numbers[4], numbers[5]}});
  }
  std::vector<Vec3> directions;
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    directions.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  }
  return std::make_unique<LinearKinematics>(directions);
}

AxisValues UsbProfile::values(double UsbAxis::*member) const {
  AxisValues all{};
  for (std::size_t i = 0; i < axes.size(); ++i) all[i] = axes[i].*member;
  return all;
}

UsbProfile read_usb_profile(const std::filesystem::path& file) {
  Diagnostics diagnostics;
  const auto tree =
      read_yaml(file, file.string(), {"a profile of a USB device", "title, usb, report, ..."}, diagnostics);
  return checked(tree, file, diagnostics);
}

UsbProfile parse_usb_profile(const std::string& text, const std::string& file) {
  Diagnostics diagnostics;
  const auto tree = parse_yaml(text, file, diagnostics);
  return checked(tree, file, diagnostics);
}

std::vector<UsbProfile> all_usb_profiles(std::vector<std::string>& notes) {
  std::vector<UsbProfile> profiles;
  for (const std::filesystem::path& file : files_of(profiles_of("usb"))) {
    try {
      profiles.push_back(read_usb_profile(file));
    } catch (const InputError& error) {
      notes.push_back(broken_profile(file, error));
    }
  }
  return profiles;
}

}  // namespace tactor
