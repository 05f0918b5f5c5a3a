#include "app/run/compare_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "framework/core/message_batch.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor {

using ComparedJson = nlohmann::ordered_json;

namespace {

/// The first field in which two messages, or two records, differ; empty where none does.
std::string differing_field(const std::vector<Field>& fields, const std::byte* was, const std::byte* now) {
  for (const Field& field : fields) {
    const std::byte* a = was + field.offset;
    const std::byte* b = now + field.offset;
    const std::size_t size = element_size(field);
    if (field.changes_size) {
      const auto& mine = *reinterpret_cast<const SharedBytes*>(a);
      const auto& other = *reinterpret_cast<const SharedBytes*>(b);
      const std::size_t bytes = mine.count() * count_of(field) * size;
      const bool same =
          mine.count() == other.count() && (bytes == 0 || std::memcmp(mine.elements(), other.elements(), bytes) == 0);
      if (!same) return field.name;
    } else if (field.kind == FieldKind::record) {
      for (std::size_t i = 0; i < count_of(field); ++i) {
        const std::string inner = differing_field(field.fields, a + i * size, b + i * size);
        if (!inner.empty()) return field.name + "." + inner;
      }
    } else if (std::memcmp(a, b, count_of(field) * size) != 0) {
      return field.name;
    }
  }
  return {};
}

std::string differing_stamp(const Stamp& was, const Stamp& now) {
  if (was.valid != now.valid) return "valid_ns";
  if (was.produced != now.produced) return "produced_ns";
  return was.sequence != now.sequence ? "sequence" : "";
}

/// How a stream differs from that of another recording; empty where it does not.
std::string stream_difference(RecordingReader& was, std::size_t mine, RecordingReader& now, std::size_t its) {
  constexpr std::uint64_t block = 4096;
  const RecordedStream& a = was.streams()[mine];
  const RecordedStream& b = now.streams()[its];
  if (!same_type(a.type, b.type)) return "its messages have other fields now";
  const std::uint64_t both = std::min(a.count, b.count);
  for (std::uint64_t first = 0; first < both; first += block) {
    const std::uint64_t count = std::min(block, both - first);
    MessageBatch then(a.type), again(a.type);
    was.read(mine, first, count, then);
    now.read(its, first, count, again);
    for (std::size_t i = 0; i < count; ++i) {
      std::string field = differing_stamp(then.stamp(i), again.stamp(i));
      if (field.empty()) field = differing_field(a.type.fields, then.value(i), again.value(i));
      if (field.empty()) continue;
      return fmt::format("row {}, at {} s: {}", first + i, then.stamp(i).valid.seconds(), field);
    }
  }
  return a.count == b.count ? "" : fmt::format("{} messages, now {}", a.count, b.count);
}

/// What a summary says beside results: names, what was measured, and what the plan chose.
bool is_no_result(const std::string& name) {
  static const std::set<std::string, std::less<>> apart{
      "tactor",     "metric_definitions", "graph",         "wall_s", "cpu_s",   "realtime_factor",
      "provenance", "peak_memory_MB",     "reference_run", "chosen", "left_out"};
  const std::string_view first = std::string_view(name).substr(0, name.find_first_of(".["));
  if (apart.contains(first)) return true;
  constexpr std::array<std::string_view, 3> measured{".median", ".p99", ".total_s"};
  return first == "cost_us" &&
         std::any_of(measured.begin(), measured.end(), [&](std::string_view ending) { return name.ends_with(ending); });
}

using Values = std::map<std::string, ComparedJson>;

/// Every number and text of a summary, by its dotted name.
void add_values(const ComparedJson& json, const std::string& name, Values& values) {
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) add_values(value, name.empty() ? key : name + "." + key, values);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) add_values(json[i], fmt::format("{}[{}]", name, i), values);
  } else if (!is_no_result(name)) {
    values[name] = json;
  }
}

}  // namespace

void compare_recordings(RecordingReader& was, RecordingReader& now, ResultComparison& found) {
  for (std::size_t i = 0; i < was.streams().size(); ++i) {
    const std::string& name = was.streams()[i].name;
    ++found.data_sets;
    const auto other = std::find_if(now.streams().begin(), now.streams().end(),
                                    [&](const RecordedStream& stream) { return stream.name == name; });
    const std::string difference =
        other == now.streams().end()
            ? "gone"
            : stream_difference(was, i, now, static_cast<std::size_t>(other - now.streams().begin()));
    if (difference.empty()) ++found.equal_data_sets;
    if (!difference.empty()) found.differences.push_back(fmt::format("data set {}: {}", name, difference));
  }
}

void compare_summaries(const ComparedJson& was, const ComparedJson& now, ResultComparison& found) {
  Values then, again;
  add_values(was, "", then);
  add_values(now, "", again);
  found.metrics += then.size();
  for (const auto& [name, value] : then) {
    const auto other = again.find(name);
    if (other != again.end() && other->second == value) {
      ++found.equal_metrics;
    } else {
      found.differences.push_back(fmt::format("metric {}: {}, now {}", name, value.dump(),
                                              other == again.end() ? "gone" : other->second.dump()));
    }
  }
  for (const auto& [name, value] : again) {
    if (!then.contains(name)) found.differences.push_back(fmt::format("metric {}: now {}", name, value.dump()));
  }
}

}  // namespace tactor
