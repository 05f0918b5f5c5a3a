#include "app/run/warm_up.hpp"

#include <nlohmann/json.hpp>
#include <string>

#include "framework/core/disk_cache.hpp"

namespace tactor {

namespace {

/// Version of the bytes; the code that finds them is in their key.
constexpr std::uint32_t warmth_layout = 1;

std::string to_bytes(const Warmth& warmth) {
  nlohmann::json json{{"last", warmth.last}, {"when", warmth.when}};
  if (warmth.since) json["since_ns"] = warmth.since->ns;
  return json.dump();
}

/// Nothing where the bytes are none.
std::optional<Warmth> warmth_from_bytes(std::string_view bytes) {
  const nlohmann::json json = nlohmann::json::parse(bytes, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  const auto last = json.find("last"), when = json.find("when"), since = json.find("since_ns");
  if (last == json.end() || !last->is_string() || when == json.end() || !when->is_string()) return std::nullopt;
  Warmth warmth{std::nullopt, last->get<std::string>(), when->get<std::string>()};
  if (since != json.end() && since->is_number_integer()) warmth.since = Time{since->get<std::int64_t>()};
  return warmth;
}

/// What reference_key leaves out: the costs of the nodes, with the bytes of their traces.
std::string costs_of(const Plan& plan) {
  std::string text = to_yaml(plan.graph);
  for (const NodeSpec& node : plan.nodes) {
    for (const Duration& cost : node.cost.trace) text += " " + std::to_string(cost.ns);
  }
  return text;
}

}  // namespace

Warmth cached_warmth(const Plan& plan, const ReferenceOptions& options) {
  if (!has_to_warm_up(plan)) return {};
  const DiskCache cache("warm", warmth_layout, options.cache_folder);
  const std::string key = content_key({costs_of(plan), reference_key(plan, code_files())});
  const auto tell = [&options](const std::string& note) {
    if (options.note && !note.empty()) options.note(note);
  };
  const DiskCache::Found found = cache.load(key);
  tell(found.note);
  if (found.bytes) {
    if (std::optional<Warmth> known = warmth_from_bytes(found.bytes->view())) return *known;
  }
  Warmth warmth = find_warmth(plan, [&options] { return !options.go_on || options.go_on(0); });
  tell(cache.store(key, to_bytes(warmth)));
  return warmth;
}

}  // namespace tactor
