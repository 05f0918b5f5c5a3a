// Reads a profile out of its YAML tree: the parts that profile.cpp and profile_registers.cpp share.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "devices/modbus/profile.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor::modbus {

inline constexpr int last_address = 65535;  ///< of a register

/// One reading; errors go to the diagnostics.
class ProfileReader {
 public:
  explicit ProfileReader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  Profile read(const Tree& tree);

 private:
  void error(const Tree& at, const std::string& message) { diagnostics_.error(at.place, message); }
  /// The value of a key that must be there; null, with an error, where it is not.
  const Tree* needed(const Tree& map, const std::string& path, const std::string& key) {
    const Tree* value = map.value(key);
    if (value == nullptr) error(map, path + ": expected the key " + key + ", found none");
    return value;
  }
  template <class Take>
  void number(const Tree& map, const std::string& path, const std::string& key, const NumberRule& rule,
              const Take& take) {
    if (const Tree* value = map.value(key)) {
      if (const auto read = read_number(*value, path + "." + key, rule, diagnostics_)) take(*read);
    }
  }
  template <class Take>
  void integer(const Tree& map, const std::string& path, const std::string& key, std::int64_t min, std::int64_t max,
               const Take& take) {
    if (const Tree* value = map.value(key)) {
      if (const auto read = read_integer(*value, path + "." + key, min, max, diagnostics_)) {
        take(static_cast<int>(*read));
      }
    }
  }
  void duration(const Tree& map, const std::string& path, const std::string& key, double most_s, bool above_zero,
                Duration& into) {
    const NumberRule rule{.unit = "s", .min = 0, .max = most_s, .above_min = above_zero};
    number(map, path, key, rule, [&into](double s) { into = Duration::from_seconds(s); });
  }
  Order order(const Tree& map, const std::string& path, const std::string& key, Order otherwise) {
    const Tree* value = map.value(key);
    if (value == nullptr) return otherwise;
    const auto word =
        read_choice(*value, path.empty() ? key : path + "." + key, {"high_first", "low_first"}, diagnostics_);
    return !word ? otherwise : *word == "high_first" ? Order::high_first : Order::low_first;
  }

  void line(const Tree& tree);
  void registers(const Tree& tree);
  void one_register(const TreeEntry& entry, const Tree& defaults);
  void functions(const Tree& tree, const std::string& path, RegisterInfo& info);
  void field(const Tree& tree, const std::string& path, RegisterInfo& info);
  std::optional<std::size_t> register_named(const Tree& name, const std::string& path, bool read, bool write);
  std::optional<double> value_of(const Tree& tree, const std::string& path, std::size_t index);
  std::optional<Expectation> expectation(const Tree& tree, const std::string& path, bool read = true);
  void identify(const Tree& tree);
  void steps(const Tree& tree, const std::string& path, std::vector<Step>& into);
  void one_step(const Tree& tree, const std::string& path, std::vector<Step>& into);
  void each_cycle(const Tree& tree);
  void status(const Tree& tree);
  void buttons(const Tree& tree);
  void watchdog(const Tree& tree);
  void fence(const Tree& tree);
  void axes(const Tree& tree);
  void one_axis(const Tree& tree, const std::string& path);
  void motor(const Tree& tree, const std::string& path, Axis& axis);
  void check_effort(const Tree& tree, const std::string& path, const Axis& axis);
  void emulated(const Tree& tree);
  void reactions(const Tree& map);
  void silence(const Tree& map);
  void values_of(const Tree& map, const std::string& path, bool write,
                 std::vector<std::pair<std::size_t, double>>& into);
  void overlaps();
  void function_23(const Tree& tree);

  Diagnostics& diagnostics_;
  Profile profile_;
};

}  // namespace tactor::modbus
