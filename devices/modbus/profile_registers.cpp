// The line and the registers of a profile.
#include <algorithm>
#include <cmath>

#include "devices/modbus/profile_reader.hpp"
#include "framework/core/units.hpp"

namespace tactor::modbus {

void ProfileReader::line(const Tree& tree) {
  if (!expect_map(tree, "line", "a map", diagnostics_)) return;
  check_keys(tree, "line", "key",
             {"baud", "parity", "stop_bits", "unit", "response_timeout", "turnaround", "silence", "rate_max"},
             diagnostics_);
  LineSettings& l = profile_.line;
  integer(tree, "line", "baud", 1200, 4'000'000, [&](int v) { l.baud = v; });
  if (const Tree* value = tree.value("parity")) {
    if (const auto word = read_choice(*value, "line.parity", {"none", "even", "odd"}, diagnostics_)) {
      l.parity = *word == "none" ? 'N' : *word == "even" ? 'E' : 'O';
    }
  }
  integer(tree, "line", "stop_bits", 1, 2, [&](int v) { l.stop_bits = v; });
  integer(tree, "line", "unit", 1, 247, [&](int v) { l.unit = v; });
  duration(tree, "line", "response_timeout", 5, true, l.response_timeout);
  duration(tree, "line", "turnaround", 1, false, l.turnaround);
  if (tree.value("silence") != nullptr) {
    l.silence.emplace();
    duration(tree, "line", "silence", 1, false, *l.silence);
  }
  number(tree, "line", "rate_max", {.unit = "Hz", .min = 0, .max = 1e4, .above_min = true},
         [&](double v) { l.rate_max = v; });
}

void ProfileReader::functions(const Tree& tree, const std::string& path, RegisterInfo& info) {
  const auto one = [&](const Tree& value) {
    const auto code = read_integer(value, path + ".function", 3, 23, diagnostics_);
    if (!code) return;
    const bool reads = *code == 3 || *code == 4, writes = *code == 6 || *code == 16 || *code == 23;
    if (!reads && !writes) {
      error(value, path + ".function: expected 3, 4, 6, 16 or 23, found " + describe(value));
    } else if ((reads && !info.readable) || (writes && !info.writable)) {
      error(value, path + ".function: expected a function of its access, found " + describe(value));
    } else if (*code == 6 && info.width() == 2) {
      error(value, path + ".function: expected 16 or 23 for a value of 32 bits, found 6, which writes 16 at a time");
    } else {
      if (reads) info.read_function = static_cast<int>(*code);
      if (writes) info.write_function = static_cast<int>(*code);
    }
  };
  const Tree* value = tree.value("function");
  if (value == nullptr) return;
  if (!value->is_sequence()) {
    one(*value);
  } else {
    for (const Tree& item : value->items) one(item);
  }
}

void ProfileReader::field(const Tree& tree, const std::string& path, RegisterInfo& info) {
  const Tree* value = tree.value("bits");
  if (value == nullptr) return;
  const std::string expected = path + ".bits: expected [lowest bit, number of bits] within 16, found ";
  if (!value->is_sequence() || value->items.size() != 2) {
    error(*value, expected + describe(*value));
    return;
  }
  if (info.type != RegisterType::uint16) {
    error(*value, path + ".bits: expected them in a uint16, found " + to_string(info.type));
    return;
  }
  const auto low = read_integer(value->items[0], path + ".bits[0]", 0, 15, diagnostics_);
  const auto bits = read_integer(value->items[1], path + ".bits[1]", 1, 16, diagnostics_);
  if (!low || !bits) return;
  if (*low + *bits > 16) {
    error(*value, expected + std::to_string(*low) + " and " + std::to_string(*bits));
    return;
  }
  info.low_bit = static_cast<int>(*low);
  info.bits = static_cast<int>(*bits);
}

void ProfileReader::one_register(const TreeEntry& entry, const Tree& defaults) {
  const std::string path = "registers." + entry.key;
  const Tree& tree = entry.value;
  if (!expect_map(tree, path, "a map", diagnostics_)) return;
  check_keys(tree, path, "key", {"address", "type", "scale", "access", "function", "bits", "word_order", "byte_order"},
             diagnostics_);
  RegisterInfo info;
  info.name = entry.key;
  info.place = entry.place;
  if (const Tree* type = needed(tree, path, "type")) {
    static const std::vector<std::string> names{"int16", "uint16", "int32", "uint32", "float32"};
    if (const auto word = read_choice(*type, path + ".type", names, diagnostics_)) {
      info.type = static_cast<RegisterType>(std::find(names.begin(), names.end(), *word) - names.begin());
    }
  }
  needed(tree, path, "address");
  integer(tree, path, "address", 0, last_address - (info.width() - 1), [&](int v) { info.address = v; });
  if (const Tree* access = needed(tree, path, "access")) {
    const auto word = read_choice(*access, path + ".access", {"read", "write", "read_write"}, diagnostics_);
    info.readable = word && *word != "write";
    info.writable = word && *word != "read";
    if (word) functions(tree, path, info);
  }
  if (const Tree* scale = tree.value("scale")) {
    const auto parsed = scale->is_scalar() ? parse_quantity(scale->text) : std::variant<Quantity, std::string>("");
    const auto* quantity = std::get_if<Quantity>(&parsed);
    if (quantity == nullptr || quantity->value_si == 0) {
      error(*scale, path + ".scale: expected what one count is, such as 1 um, found " + describe(*scale));
    } else {
      info.scale = quantity->value_si;
      info.unit = tactor::describe(quantity->dimension);
    }
  }
  field(tree, path, info);
  info.words = order(tree, path, "word_order", order(defaults, "", "word_order", Order::high_first));
  info.bytes = order(tree, path, "byte_order", order(defaults, "", "byte_order", Order::high_first));
  profile_.registers.push_back(std::move(info));
}

void ProfileReader::registers(const Tree& tree) {
  const Tree* list = needed(tree, "the profile", "registers");
  if (list == nullptr || !expect_map(*list, "registers", "a map of names to registers", diagnostics_)) return;
  for (const TreeEntry& entry : list->entries) one_register(entry, tree);
}

std::optional<std::size_t> ProfileReader::register_named(const Tree& name, const std::string& path, bool read,
                                                         bool write) {
  const auto text = read_text(name, path, diagnostics_);
  if (!text) return std::nullopt;
  std::vector<std::string> names;
  for (const RegisterInfo& info : profile_.registers) names.push_back(info.name);
  const auto found = std::find(names.begin(), names.end(), *text);
  if (found == names.end()) {
    error(name, path + ": expected one of the registers (" + list_of(names) + "), found " + describe(name) +
                    did_you_mean(*text, names));
    return std::nullopt;
  }
  const auto index = static_cast<std::size_t>(found - names.begin());
  const RegisterInfo& info = profile_.registers[index];
  if ((read && !info.readable) || (write && !info.writable)) {
    error(name, path + ": expected a register that can be " + (read ? "read" : "written") + ", found " + *text +
                    ", whose access says otherwise");
    return std::nullopt;
  }
  return index;
}

std::optional<double> ProfileReader::value_of(const Tree& tree, const std::string& path, std::size_t index) {
  const auto value = read_number(tree, path, {.unit = profile_.registers[index].unit}, diagnostics_);
  if (!value) return std::nullopt;
  const RegisterInfo& info = profile_.registers[index];
  std::uint16_t words[2] = {0, 0};
  encode(info, *value, words);
  // Read back, so that a value beyond the register is no other value silently.
  if (std::abs(decode(info, words) - *value) <= std::abs(info.scale) * 0.5000001 + std::abs(*value) * 1e-6)
    return value;
  error(tree, path + ": expected a value that " + info.name + " (" + to_string(info.type) + ") can hold, found " +
                  describe(tree));
  return std::nullopt;
}

void ProfileReader::values_of(const Tree& map, const std::string& path, bool write,
                              std::vector<std::pair<std::size_t, double>>& into) {
  if (!expect_map(map, path, "a map of registers to values", diagnostics_)) return;
  for (const TreeEntry& entry : map.entries) {
    Tree name;
    name.kind = Tree::Kind::scalar;
    name.text = entry.key;
    name.place = entry.place;
    const std::string one = path + "." + entry.key;
    const auto index = register_named(name, one, false, write);
    if (!index) continue;
    if (const auto v = value_of(entry.value, one, *index)) into.emplace_back(*index, *v);
  }
}

// Two registers that share a word must be fields of it, else writing one would change the other.
void ProfileReader::overlaps() {
  const std::vector<RegisterInfo>& list = profile_.registers;
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const RegisterInfo &a = list[i], &b = list[j];
      const bool apart = a.address + a.width() <= b.address || b.address + b.width() <= a.address;
      const bool spaces =
          (a.readable && b.readable && a.read_function == b.read_function) || (a.writable && b.writable);
      if (apart || !spaces || !a.writable || !b.writable) continue;
      const bool fields =
          a.bits > 0 && b.bits > 0 && (a.low_bit + a.bits <= b.low_bit || b.low_bit + b.bits <= a.low_bit);
      if (!fields) {
        diagnostics_.error(a.place, "registers." + a.name + ": expected words of its own, found those of " + b.name +
                                        "; give both their bits where they are fields of one register");
      } else if (a.write_function != b.write_function) {
        diagnostics_.error(a.place, "registers." + a.name + ".function: expected that of " + b.name +
                                        ", a field of the same register, found " + std::to_string(a.write_function));
      }
    }
  }
}

}  // namespace tactor::modbus
