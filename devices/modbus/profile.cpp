#include "devices/modbus/profile.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "devices/modbus/profile_reader.hpp"

namespace tactor::modbus {

namespace {

const YamlFileKind profile_file{"a profile of a Modbus device", "line, registers, identify, axes, ..."};
constexpr double longest_wait_s = 60;

}  // namespace

std::optional<Expectation> ProfileReader::expectation(const Tree& tree, const std::string& path, bool read) {
  if (!expect_map(tree, path, "a map of register and value, or min and max", diagnostics_)) return std::nullopt;
  check_keys(tree, path, "key", {"register", "value", "min", "max"}, diagnostics_);
  const Tree* name = needed(tree, path, "register");
  if (name == nullptr) return std::nullopt;
  const auto index = register_named(*name, path + ".register", read, !read);
  if (!index) return std::nullopt;
  Expectation result{*index, -HUGE_VAL, HUGE_VAL};
  const Tree *value = tree.value("value"), *min = tree.value("min"), *max = tree.value("max");
  if ((value == nullptr) == (min == nullptr && max == nullptr)) {
    error(tree, path + ": expected either value, or min and max");
    return std::nullopt;
  }
  if (value != nullptr) {
    const auto v = value_of(*value, path + ".value", *index);
    if (!v) return std::nullopt;
    const double half = 0.5 * std::abs(profile_.registers[*index].scale);
    result.min = *v - half;
    result.max = *v + half;
  }
  if (min != nullptr) result.min = value_of(*min, path + ".min", *index).value_or(result.min);
  if (max != nullptr) result.max = value_of(*max, path + ".max", *index).value_or(result.max);
  if (result.min > result.max) {
    error(tree, path + ": expected min at or below max");
    return std::nullopt;
  }
  return result;
}

void ProfileReader::identify(const Tree& tree) {
  const Tree* list = needed(tree, "the profile", "identify");
  if (list == nullptr) return;
  if (!list->is_sequence() || list->items.empty()) {
    error(*list, "identify: expected a list of registers that tell the device from another, found " + describe(*list));
    return;
  }
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    const auto e = expectation(list->items[i], "identify[" + std::to_string(i) + "]");
    if (e) profile_.identify.push_back(*e);
  }
}

void ProfileReader::one_step(const Tree& tree, const std::string& path, std::vector<Step>& into) {
  if (!expect_map(tree, path, "a map with write, wait or expect", diagnostics_)) return;
  check_keys(tree, path, "key", {"write", "wait", "expect", "value", "within"}, diagnostics_);
  const Tree *write = tree.value("write"), *wait = tree.value("wait"), *expect = tree.value("expect");
  if ((write != nullptr) + (wait != nullptr) + (expect != nullptr) != 1) {
    error(tree, path + ": expected one of write, wait and expect");
    return;
  }
  Step step;
  if (wait != nullptr) {
    step.kind = Step::Kind::wait;
    duration(tree, path, "wait", longest_wait_s, true, step.time);
    into.push_back(step);
    return;
  }
  step.kind = write != nullptr ? Step::Kind::write : Step::Kind::expect;
  const auto index = write != nullptr ? register_named(*write, path + ".write", false, true)
                                      : register_named(*expect, path + ".expect", true, false);
  const Tree* value = needed(tree, path, "value");
  if (!index || value == nullptr) return;
  step.index = *index;
  const auto v = value_of(*value, path + ".value", *index);
  if (!v) return;
  step.value = *v;
  step.time = Duration{1'000'000'000};
  duration(tree, path, "within", longest_wait_s, true, step.time);
  into.push_back(step);
}

void ProfileReader::steps(const Tree& tree, const std::string& path, std::vector<Step>& into) {
  const Tree* list = tree.value(path);
  if (list == nullptr) return;
  if (!list->is_sequence()) {
    error(*list, path + ": expected a list of steps, found " + describe(*list));
    return;
  }
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    one_step(list->items[i], path + "[" + std::to_string(i) + "]", into);
  }
}

void ProfileReader::each_cycle(const Tree& tree) {
  if (const Tree* map = tree.value("each_cycle")) values_of(*map, "each_cycle", true, profile_.each_cycle);
  if (const Tree* map = tree.value("at_zero")) values_of(*map, "at_zero", true, profile_.at_zero);
}

void ProfileReader::status(const Tree& tree) {
  const Tree* map = tree.value("status");
  if (map == nullptr || !expect_map(*map, "status", "a map of registers", diagnostics_)) return;
  for (const TreeEntry& entry : map->entries) {
    const std::string path = "status." + entry.key;
    Tree name;
    name.kind = Tree::Kind::scalar;
    name.text = entry.key;
    name.place = entry.place;
    const auto index = register_named(name, path, true, false);
    if (!index || !expect_map(entry.value, path, "a map", diagnostics_)) continue;
    check_keys(entry.value, path, "key", {"every", "faults", "notes", "others", "holds"}, diagnostics_);
    Status result;
    result.index = *index;
    integer(entry.value, path, "every", 1, 1000, [&](int v) { result.every = v; });
    for (const bool fault : {true, false}) {
      const std::string key = fault ? "faults" : "notes";
      const Tree* bits = entry.value.value(key);
      if (bits == nullptr || !expect_map(*bits, path + "." + key, "a map of bits to texts", diagnostics_)) continue;
      for (const TreeEntry& bit : bits->entries) {
        Tree number = name;
        number.text = bit.key;
        number.place = bit.place;
        const auto b =
            read_integer(number, path + "." + key, 0, 16 * profile_.registers[*index].width() - 1, diagnostics_);
        const auto means = read_text(bit.value, path + "." + key + "." + bit.key, diagnostics_);
        if (b && means) result.bits.push_back({static_cast<int>(*b), *means, fault});
      }
    }
    if (const Tree* others = entry.value.value("others")) {
      const auto word = read_choice(*others, path + ".others", {"fault", "ignore"}, diagnostics_);
      result.others_are_faults = word && *word == "fault";
    }
    if (const Tree* holds = entry.value.value("holds")) result.holds = value_of(*holds, path + ".holds", *index);
    profile_.status.push_back(std::move(result));
  }
}

void ProfileReader::buttons(const Tree& tree) {
  const Tree* list = tree.value("buttons");
  if (list == nullptr) return;
  if (!list->is_sequence() || list->items.size() > 31) {
    error(*list, "buttons: expected a list of at most 31, found " + describe(*list));
    return;
  }
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    const std::string path = "buttons[" + std::to_string(i) + "]";
    const Tree& item = list->items[i];
    if (!expect_map(item, path, "a map of register and bit", diagnostics_)) continue;
    check_keys(item, path, "key", {"register", "bit"}, diagnostics_);
    const Tree* name = needed(item, path, "register");
    needed(item, path, "bit");
    const auto index = name == nullptr ? std::nullopt : register_named(*name, path + ".register", true, false);
    if (!index) continue;
    Button button{*index, 0};
    integer(item, path, "bit", 0, 15, [&](int v) { button.bit = v; });
    profile_.buttons.push_back(button);
  }
}

void ProfileReader::watchdog(const Tree& tree) {
  const Tree* map = tree.value("watchdog");
  if (map == nullptr || !expect_map(*map, "watchdog", "a map of register and time", diagnostics_)) return;
  check_keys(*map, "watchdog", "key", {"register", "time"}, diagnostics_);
  const Tree *name = needed(*map, "watchdog", "register"), *time = needed(*map, "watchdog", "time");
  if (name == nullptr || time == nullptr) return;
  const auto index = register_named(*name, "watchdog.register", false, true);
  if (!index) return;
  if (profile_.registers[*index].unit != "s") {
    error(*name, "watchdog.register: expected a register whose scale is a time, found one in " +
                     profile_.registers[*index].unit);
    return;
  }
  const auto seconds = value_of(*time, "watchdog.time", *index);
  if (!seconds) return;
  // As the device gets it; many take zero for none.
  std::uint16_t words[2] = {0, 0};
  encode(profile_.registers[*index], *seconds, words);
  const double counted = decode(profile_.registers[*index], words);
  if (counted > 0) {
    profile_.watchdog = {*index, Duration::from_seconds(counted)};
  } else {
    error(*time, "watchdog.time: expected a time of at least a count of its register, found " + describe(*time));
  }
}

void ProfileReader::fence(const Tree& tree) {
  const Tree* map = tree.value("fence");
  if (map == nullptr || !expect_map(*map, "fence", "a map of address, count and function", diagnostics_)) return;
  check_keys(*map, "fence", "key", {"address", "count", "function"}, diagnostics_);
  needed(*map, "fence", "address");
  needed(*map, "fence", "count");
  Fence result;
  integer(*map, "fence", "function", 3, 4, [&](int v) { result.function = v; });
  integer(*map, "fence", "address", 0, last_address, [&](int v) { result.address = v; });
  integer(*map, "fence", "count", 1, 125, [&](int v) { result.count = v; });
  profile_.fence = result;
}

/// How warm the motor may become: both numbers, or neither.
void ProfileReader::motor(const Tree& tree, const std::string& path, Axis& axis) {
  const Tree *continuous = tree.value("effort_continuous"), *time = tree.value("thermal_time");
  if ((continuous == nullptr) != (time == nullptr)) {
    error(tree, path + ": expected effort_continuous and thermal_time together, found " +
                    (continuous == nullptr ? "thermal_time" : "effort_continuous") + " alone");
    return;
  }
  number(tree, path, "effort_continuous", {.unit = "N", .min = 0, .max = axis.effort_max, .above_min = true},
         [&](double v) { axis.effort_continuous = v; });
  number(tree, path, "thermal_time", {.unit = "s", .min = 1, .max = 1e5}, [&](double v) { axis.thermal_time = v; });
}

void ProfileReader::one_axis(const Tree& tree, const std::string& path) {
  if (!expect_map(tree, path, "a map", diagnostics_)) return;
  check_keys(tree, path, "key",
             {"position", "effort", "direction", "effort_max", "effort_continuous", "thermal_time", "speed_max",
              "jump_tolerance", "effort_as", "sign"},
             diagnostics_);
  Axis axis;
  const Tree *position = needed(tree, path, "position"), *effort = needed(tree, path, "effort");
  const auto p = position == nullptr ? std::nullopt : register_named(*position, path + ".position", true, false);
  const auto e = effort == nullptr ? std::nullopt : register_named(*effort, path + ".effort", false, true);
  const auto in_unit = [&](const std::optional<std::size_t>& index, const Tree* at, const char* unit,
                           const char* what) {
    if (!index || profile_.registers[*index].unit == unit) return;
    error(*at, path + "." + what + ": expected a register whose scale is in " + unit + ", found one in " +
                   profile_.registers[*index].unit);
  };
  in_unit(p, position, "m", "position");
  in_unit(e, effort, "N", "effort");
  axis.position = p.value_or(0);
  axis.effort = e.value_or(0);
  if (const Tree* direction = tree.value("direction")) {
    if (const auto v = read_numbers(*direction, path + ".direction", 3, {}, diagnostics_)) {
      axis.direction = {(*v)[0], (*v)[1], (*v)[2]};
      if (!(norm(axis.direction) > 1e-9)) error(*direction, path + ".direction: expected a length above zero");
    }
  }
  needed(tree, path, "effort_max");
  needed(tree, path, "speed_max");
  needed(tree, path, "jump_tolerance");
  number(tree, path, "effort_max", {.unit = "N", .min = 0, .max = 1e5, .above_min = true},
         [&](double v) { axis.effort_max = v; });
  motor(tree, path, axis);
  number(tree, path, "speed_max", {.unit = "m/s", .min = 0, .max = 100, .above_min = true},
         [&](double v) { axis.speed_max = v; });
  number(tree, path, "jump_tolerance", {.unit = "m", .min = 0, .max = 1}, [&](double v) { axis.jump_tolerance = v; });
  if (const Tree* as = tree.value("effort_as")) {
    const auto word = read_choice(*as, path + ".effort_as", {"signed", "magnitude"}, diagnostics_);
    axis.magnitude = word && *word == "magnitude";
  }
  if (const Tree* sign = tree.value("sign")) {
    const std::string sign_path = path + ".sign";
    if (expect_map(*sign, sign_path, "a map of register, positive, negative and zero", diagnostics_)) {
      check_keys(*sign, sign_path, "key", {"register", "positive", "negative", "zero"}, diagnostics_);
      const Tree* name = needed(*sign, sign_path, "register");
      axis.sign = name == nullptr ? std::nullopt : register_named(*name, sign_path + ".register", false, true);
      const auto take = [&](const char* key, double& into) {
        const Tree* value = needed(*sign, sign_path, key);
        if (value != nullptr && axis.sign) into = value_of(*value, sign_path + "." + key, *axis.sign).value_or(0);
      };
      take("positive", axis.positive);
      take("negative", axis.negative);
      take("zero", axis.zero);
    }
  }
  if (e) check_effort(tree, path, axis);
  profile_.axes.push_back(axis);
}

// A force that the registers cannot say would become another one, or one in the other direction.
void ProfileReader::check_effort(const Tree& tree, const std::string& path, const Axis& axis) {
  if (axis.magnitude != (tree.value("sign") != nullptr)) {
    error(tree, path + ": expected effort_as: magnitude and sign together, found only " +
                    (axis.magnitude ? "effort_as: magnitude" : "sign"));
    return;
  }
  const RegisterInfo& info = profile_.registers[axis.effort];
  const auto holds = [&info](double value) {
    std::uint16_t words[2] = {0, 0};
    encode(info, value, words);
    return std::abs(decode(info, words) - value) <= std::abs(info.scale) * 0.5000001 + std::abs(value) * 1e-6;
  };
  if (holds(axis.effort_max) && (axis.magnitude || holds(-axis.effort_max))) return;
  error(*tree.value("effort"), path + ".effort: expected a register that can hold " +
                                   (axis.magnitude ? "effort_max" : "effort_max in both directions") + ", found " +
                                   info.name + " (" + to_string(info.type) + ")");
}

void ProfileReader::axes(const Tree& tree) {
  const Tree* list = needed(tree, "the profile", "axes");
  if (list == nullptr) return;
  if (!list->is_sequence() || list->items.empty() || list->items.size() > 3) {
    error(*list, "axes: expected a list of one to three axes, found " +
                     (list->is_sequence() ? "a list of " + std::to_string(list->items.size()) : describe(*list)));
    return;
  }
  for (std::size_t i = 0; i < list->items.size(); ++i) one_axis(list->items[i], "axes[" + std::to_string(i) + "]");
  for (std::size_t i = 0; i < profile_.axes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 &a = profile_.axes[i].direction, &b = profile_.axes[j].direction;
      if (std::abs(dot(a, b)) > 1e-6 * norm(a) * norm(b)) {
        error(list->items[i],
              "axes[" + std::to_string(i) + "].direction: expected directions at right angles to one another");
      }
    }
  }
}

// Function 23 is that of the combined cycle, which has one block of words to write.
void ProfileReader::function_23(const Tree& tree) {
  std::vector<RegisterInfo> cycle;
  for (const std::size_t index : profile_.written_each_cycle()) cycle.push_back(profile_.registers[index]);
  std::sort(cycle.begin(), cycle.end(),
            [](const RegisterInfo& a, const RegisterInfo& b) { return a.address < b.address; });
  const auto by_23 = [](const RegisterInfo& info) { return info.writable && info.write_function == 23; };
  const auto refuse = [&](const RegisterInfo& info, const std::string& what) {
    diagnostics_.error(info.place, "registers." + info.name + ".function: expected " + what + ", found 23");
  };
  for (const RegisterInfo& info : profile_.registers) {
    const auto same = [&](const RegisterInfo& other) { return other.name == info.name; };
    if (!by_23(info)) continue;
    if (!profile_.combined) {
      refuse(info, "6 or 16 where the cycle is separate (function 23 is for cycle: combined)");
    } else if (std::none_of(cycle.begin(), cycle.end(), same)) {
      refuse(info, "6 or 16 for a register that is not written in each cycle");
    }
  }
  if (!profile_.combined) return;
  const auto first = std::find_if(cycle.begin(), cycle.end(), by_23);
  if (first == cycle.end()) {
    error(*tree.value("cycle"),
          "cycle: expected a register with function: 23 among those that are written in each cycle, found none");
    return;
  }
  int end = first->address;
  for (const RegisterInfo& info : cycle) {
    if (!by_23(info)) continue;
    if (info.address > end) refuse(info, "6 or 16 for words apart from those of " + first->name);
    end = std::max(end, info.address + info.width());
  }
  const auto reads_by_3 = [&](const Axis& axis) { return profile_.registers[axis.position].read_function == 3; };
  if (std::none_of(profile_.axes.begin(), profile_.axes.end(), reads_by_3)) {
    error(*tree.value("cycle"), "cycle: expected a position that is read by function 3 to combine, found none");
  }
}

void ProfileReader::emulated(const Tree& tree) {
  const Tree* map = tree.value("emulated");
  if (map == nullptr || !expect_map(*map, "emulated", "a map", diagnostics_)) return;
  check_keys(*map, "emulated", "key",
             {"mass", "damping", "stiffness", "travel", "rest", "swing", "swing_rate", "enabled", "error",
              "watchdog_bit", "initial", "reacts", "silence"},
             diagnostics_);
  EmulatedDynamics& e = profile_.emulated;
  const auto take = [&](const char* key, const char* unit, double min, double max, bool above, double& into) {
    number(*map, "emulated", key, {.unit = unit, .min = min, .max = max, .above_min = above},
           [&into](double v) { into = v; });
  };
  take("mass", "kg", 1e-3, 1e3, false, e.mass);
  take("damping", "N s/m", 0, 1e4, false, e.damping);
  take("stiffness", "N/m", 0, 1e5, false, e.stiffness);
  take("travel", "m", 0, 10, true, e.travel);
  take("rest", "m", 0, 10, false, e.rest);
  take("swing", "m", 0, 10, false, e.swing);
  take("swing_rate", "Hz", 0, 20, true, e.swing_rate);
  if (const Tree* enabled = map->value("enabled")) e.enabled = expectation(*enabled, "emulated.enabled", false);
  if (const Tree* fault = map->value("error")) e.error = register_named(*fault, "emulated.error", true, false);
  integer(*map, "emulated", "watchdog_bit", 0, 15, [&](int v) { e.watchdog_bit = v; });
  if (const Tree* initial = map->value("initial")) values_of(*initial, "emulated.initial", false, e.initial);
  reactions(*map);
  silence(*map);
}

void ProfileReader::silence(const Tree& map) {
  const Tree* tree = map.value("silence");
  const std::string path = "emulated.silence";
  if (tree == nullptr || !expect_map(*tree, path, "a map of after, sets and to", diagnostics_)) return;
  check_keys(*tree, path, "key", {"after", "sets", "to"}, diagnostics_);
  const Tree *sets = needed(*tree, path, "sets"), *to = needed(*tree, path, "to");
  if (needed(*tree, path, "after") == nullptr || sets == nullptr || to == nullptr) return;
  EmulatedDynamics::Silence result;
  duration(*tree, path, "after", longest_wait_s, true, result.after);
  const auto s = register_named(*sets, path + ".sets", true, false);
  const auto t = s ? value_of(*to, path + ".to", *s) : std::nullopt;
  if (!t) return;
  result.sets = *s;
  result.to = *t;
  profile_.emulated.silence = result;
}

void ProfileReader::reactions(const Tree& map) {
  const Tree* list = map.value("reacts");
  if (list == nullptr) return;
  if (!list->is_sequence()) {
    error(*list, "emulated.reacts: expected a list, found " + describe(*list));
    return;
  }
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    const std::string path = "emulated.reacts[" + std::to_string(i) + "]";
    const Tree& item = list->items[i];
    if (!expect_map(item, path, "a map of when, value, sets and to", diagnostics_)) continue;
    check_keys(item, path, "key", {"when", "value", "sets", "to"}, diagnostics_);
    const Tree *when = needed(item, path, "when"), *value = needed(item, path, "value");
    const Tree *sets = needed(item, path, "sets"), *to = needed(item, path, "to");
    if (when == nullptr || value == nullptr || sets == nullptr || to == nullptr) continue;
    const auto w = register_named(*when, path + ".when", false, true);
    const auto s = register_named(*sets, path + ".sets", true, false);
    const auto v = w ? value_of(*value, path + ".value", *w) : std::nullopt;
    const auto t = s ? value_of(*to, path + ".to", *s) : std::nullopt;
    if (v && t) profile_.emulated.reacts.push_back({*w, *v, *s, *t});
  }
}

Profile ProfileReader::read(const Tree& tree) {
  profile_.places.file = tree.place;
  const auto place_of = [&tree](const char* key) {
    const Tree* value = tree.value(key);
    return value == nullptr ? tree.place : value->place;
  };
  profile_.places.cycle = place_of("cycle");
  profile_.places.fence = place_of("fence");
  profile_.places.watchdog = place_of("watchdog");
  check_keys(
      tree, "", "key",
      {"title", "line", "word_order", "byte_order", "registers", "identify", "start_up", "shut_down", "calibrate",
       "each_cycle", "at_zero", "cycle", "read_gap", "status", "buttons", "watchdog", "fence", "axes", "emulated"},
      diagnostics_);
  if (const Tree* title = tree.value("title")) profile_.title = read_text(*title, "title", diagnostics_).value_or("");
  if (const Tree* l = tree.value("line")) line(*l);
  order(tree, "", "word_order", Order::high_first);
  order(tree, "", "byte_order", Order::high_first);
  registers(tree);
  // What refers to registers is read where all of them are known, so that one mistake is told once.
  if (diagnostics_.any()) return std::move(profile_);
  identify(tree);
  steps(tree, "start_up", profile_.start_up);
  steps(tree, "shut_down", profile_.shut_down);
  steps(tree, "calibrate", profile_.calibrate);
  each_cycle(tree);
  if (const Tree* cycle = tree.value("cycle")) {
    const auto word = read_choice(*cycle, "cycle", {"combined", "separate"}, diagnostics_);
    profile_.combined = word && *word == "combined";
  }
  integer(tree, "the profile", "read_gap", 0, 120, [&](int v) { profile_.read_gap = v; });
  status(tree);
  buttons(tree);
  watchdog(tree);
  fence(tree);
  axes(tree);
  emulated(tree);
  overlaps();
  if (!diagnostics_.any()) function_23(tree);
  return std::move(profile_);
}

namespace {

Profile finish(const std::optional<Tree>& tree, const std::string& file, Diagnostics& diagnostics) {
  Profile profile;
  if (tree) profile = ProfileReader(diagnostics).read(*tree);
  diagnostics.throw_if_any();
  profile.name = std::filesystem::path(file).stem().string();
  return profile;
}

}  // namespace

Profile read_profile(const std::filesystem::path& file) {
  Diagnostics diagnostics;
  const auto tree = read_yaml(file, file.string(), profile_file, diagnostics);
  return finish(tree, file.string(), diagnostics);
}

Profile parse_profile(const std::string& text, const std::string& file) {
  Diagnostics diagnostics;
  auto tree = parse_yaml(text, file, diagnostics);
  if (tree && !tree->is_map()) {
    const SourceLocation place = tree->place.line > 0 ? tree->place : SourceLocation{file, 0, 0};
    diagnostics.error(place, "expected a map with the keys " + profile_file.keys + ", found " + describe(*tree));
    tree.reset();
  }
  return finish(tree, file, diagnostics);
}

}  // namespace tactor::modbus
