#include <charconv>
#include <cmath>
#include <cstdint>
#include <sstream>

#include "framework/core/input_file.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_trace_lines = 10'000'000;
constexpr std::uint64_t max_trace_bytes = std::uint64_t{1} << 28U;

// One duration in seconds a line; empty lines and lines that begin with # are skipped.
std::vector<Duration> read_trace(const fs::path& file, Diagnostics& diagnostics) {
  std::vector<Duration> trace;
  std::istringstream stream;
  try {
    stream.str(read_input_file(file, max_trace_bytes));
  } catch (const InputError& error) {
    diagnostics.error({file.string(), 0, 0}, error.what());
    return {};
  }
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    double seconds = 0;
    const auto result = std::from_chars(line.data(), line.data() + line.size(), seconds);
    const bool number_alone = result.ec == std::errc{} && result.ptr == line.data() + line.size();
    if (!number_alone || !std::isfinite(seconds) || seconds < 0 || seconds > longest_time_s) {
      Tree text;
      text.kind = Tree::Kind::scalar;
      text.text = line;
      diagnostics.error({file.string(), number, 1}, "expected a duration in seconds, found " + describe(text));
      return {};
    }
    if (trace.size() == max_trace_lines) {
      diagnostics.error({file.string(), number, 1},
                        "expected at most " + std::to_string(max_trace_lines) + " durations, found more");
      return {};
    }
    trace.push_back(Duration::from_seconds(seconds));
  }
  if (trace.empty()) diagnostics.error({file.string(), 0, 0}, "expected durations in seconds, found none");
  return trace;
}

void read_trace_cost(CostModel& cost, const Tree& tree, const std::string& path, const FileFinder& files,
                     Diagnostics& diagnostics) {
  check_keys(tree, path, "key", {"trace"}, diagnostics);
  cost.kind = CostModel::Kind::trace;
  const auto file = files.find(tree.find("trace")->value, path + ".trace", any_file, diagnostics);
  if (!file) return;
  cost.trace_file = *file;
  cost.trace = read_trace(*file, diagnostics);
}

}  // namespace

CostModel read_cost(const Tree& tree, const std::string& path, const FileFinder& files, Diagnostics& diagnostics) {
  CostModel cost;
  if (tree.is_scalar() && tree.text == "none") return cost;
  const bool constant = tree.find("constant") != nullptr;
  const bool per_item = tree.find("per_contact") != nullptr;
  const bool trace = tree.find("trace") != nullptr;
  if (static_cast<int>(constant) + static_cast<int>(per_item) + static_cast<int>(trace) != 1) {
    std::vector<std::string> keys;
    for (const TreeEntry& entry : tree.entries) keys.push_back(entry.key);
    std::string message = path + ": expected none or a map with one of constant, per_contact, trace, found " +
                          (keys.empty() ? describe(tree) : list_of(keys));
    if (const Tree* base = tree.value("base"); base != nullptr && !constant && !trace) {
      message += "; base needs per_contact: for a cost that does not grow with contacts, write constant: " +
                 (base->is_scalar() ? base->text : "TIME");
    }
    diagnostics.error(tree.place, message);
    return cost;
  }
  if (trace) {
    read_trace_cost(cost, tree, path, files, diagnostics);
    return cost;
  }
  cost.kind = constant ? CostModel::Kind::constant : CostModel::Kind::per_item;
  const std::vector<std::string> keys = constant
                                            ? std::vector<std::string>{"constant", "jitter", "min", "max"}
                                            : std::vector<std::string>{"per_contact", "base", "jitter", "min", "max"};
  check_keys(tree, path, "key", keys, diagnostics);
  const auto duration = [&](std::string_view key) -> std::optional<Duration> {
    const TreeEntry* entry = tree.find(key);
    if (entry == nullptr) return std::nullopt;
    return read_duration(entry->value, path + "." + std::string(key), false, diagnostics);
  };
  cost.base = duration(constant ? "constant" : "base").value_or(Duration{});
  if (per_item) cost.each = duration("per_contact").value_or(Duration{});
  cost.min = duration("min").value_or(Duration{});
  cost.max = duration("max");
  if (const TreeEntry* jitter = tree.find("jitter")) {
    cost.jitter = read_number(jitter->value, path + ".jitter", {.min = 0, .max = 1}, diagnostics).value_or(0);
  }
  if (cost.max && *cost.max < cost.min) {
    diagnostics.error(tree.find("max")->place, path + ".max: expected at least min (" +
                                                   number_text(cost.min.seconds()) + " s), found " +
                                                   describe(tree.find("max")->value));
  }
  return cost;
}

}  // namespace tactor
