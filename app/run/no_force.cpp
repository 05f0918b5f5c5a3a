#include "app/run/no_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "framework/core/refusals.hpp"
#include "framework/realtime/device_node.hpp"

namespace tactor {

namespace {

std::uint64_t ticks_of(const TicksByCause& ticks, SafetyCause cause) {
  return ticks[static_cast<std::size_t>(cause)];
}

/// The way of the force to a device, from its input back to where it begins.
class Upstream {
 public:
  Upstream(const PlanNodes& nodes, const std::vector<EdgeStatistics>& edges, const std::vector<std::uint64_t>& steps)
      : nodes_(nodes), edges_(edges), steps_(steps) {}

  /// That a node on the way could use nothing of what came.
  [[nodiscard]] std::optional<NoForce> refused(std::size_t device) const {
    for (const std::size_t n : before(device)) {
      const auto* node = dynamic_cast<const Refusing*>(&nodes_[n]);
      if (node == nullptr) continue;
      const Refusals& refusals = node->refusals();
      if (refusals.refused() == 0 || refusals.refused() < refusals.came()) continue;
      return NoForce{{},
                     NoForceReason::results_refused,
                     refusals.refused(),
                     refusals.came(),
                     fmt::format("{} of {} {} refused: {} (node {})", refusals.refused(), refusals.came(),
                                 refusals.what(), reasons(refusals), nodes_.plan().nodes[n].name)};
    }
    return std::nullopt;
  }

  /// The node at which the way ends: it got all that it needs, or needs nothing, and sent nothing.
  [[nodiscard]] NoForce silent(std::size_t device) const {
    std::size_t node = device;
    std::set<std::size_t> seen;
    for (std::optional<std::size_t> next = silent_before(node); next && seen.insert(*next).second;) {
      node = *next;
      next = silent_before(node);
    }
    const std::string& name = nodes_.plan().nodes[node].name;
    const std::uint64_t steps = steps_[node];
    std::string text = nodes_.plan().nodes[node].info->fed
                           ? fmt::format("no result came: nothing was fed into node {}", name)
                       : steps == 0 ? fmt::format("no result came: node {} never finished a step", name)
                                    : fmt::format("no result came: node {} sent nothing in {} steps", name, steps);
    return {{}, NoForceReason::no_result, steps, steps, std::move(text)};
  }

 private:
  static std::string reasons(const Refusals& refusals) {
    std::string text;
    for (std::size_t r = 1; r < refusal_count; ++r) {
      const auto why = static_cast<RefusalReason>(r);
      if (refusals.refused(why) == 0) continue;
      if (!text.empty()) text += ", ";
      if (refusals.refused(why) < refusals.refused()) text += fmt::format("{} ", refusals.refused(why));
      text += why == RefusalReason::too_many
                  ? fmt::format("{} {} in an array of {}", refusals.found(), refusals.items(), refusals.room())
                  : std::string(refusal_words[r]);
    }
    return text;
  }

  /// All nodes whose messages may end in a force of this device, the nearest first; other devices end the way.
  [[nodiscard]] std::vector<std::size_t> before(std::size_t device) const {
    const Plan& plan = nodes_.plan();
    std::vector<std::size_t> found;
    std::vector<std::size_t> at{device};
    for (std::size_t i = 0; i < at.size(); ++i) {
      for (const PlannedEdge& edge : plan.edges) {
        if (edge.to != at[i] || plan.nodes[edge.from].info->actuator) continue;
        if (edge.to == device && !is_force(edge)) continue;
        if (std::find(at.begin(), at.end(), edge.from) != at.end()) continue;
        at.push_back(edge.from);
        found.push_back(edge.from);
      }
    }
    return found;
  }

  [[nodiscard]] bool is_force(const PlannedEdge& edge) const {
    return same_type(*nodes_.plan().nodes[edge.to].info->inputs[edge.input].type, message_type<ForceSegment>());
  }

  /// A node from which nothing has come that `node` needs; of several, the one that has stepped least.
  [[nodiscard]] std::optional<std::size_t> silent_before(std::size_t node) const {
    const Plan& plan = nodes_.plan();
    std::optional<std::size_t> found;
    for (std::size_t e = 0; e < plan.edges.size(); ++e) {
      const PlannedEdge& edge = plan.edges[e];
      if (edge.to != node || edges_[e].delivered > 0) continue;
      const NodeInfo& info = *plan.nodes[node].info;
      if (info.actuator ? !is_force(edge) : !edge.triggers && !info.inputs[edge.input].required) continue;
      if (!found || steps_[edge.from] < steps_[*found]) found = edge.from;
    }
    return found;
  }

  const PlanNodes& nodes_;
  const std::vector<EdgeStatistics>& edges_;
  const std::vector<std::uint64_t>& steps_;
};

/// Among the ticks that wanted a force, why none went out.
NoForce withheld(const ForceAccount& account) {
  struct Cause {
    SafetyCause cause;
    NoForceReason reason;
    std::string text;
  };
  const std::array<Cause, 8> known{{
      {SafetyCause::not_finite, NoForceReason::not_finite, "the force was not finite"},
      {SafetyCause::overspeed, NoForceReason::overspeed, "the handle was too fast, or had been just before"},
      {SafetyCause::read_failed, NoForceReason::read_failed, "the device could not be read, or had failed just before"},
      {SafetyCause::write_failed, NoForceReason::write_failed, "the device took no wrench"},
      {SafetyCause::time_reversed, NoForceReason::time_reversed, "the clock had been set back"},
      {SafetyCause::dead_man, NoForceReason::dead_man, fmt::format("button {} was not held", account.dead_man_button)},
      {SafetyCause::outside_workspace, NoForceReason::outside_workspace,
       "the handle was outside the device's workspace"},
      {SafetyCause::stale, NoForceReason::stale, "the force was stale"},
  }};
  NoForce found{{}, NoForceReason::mixed, 0, account.gate.wanted, {}};
  std::size_t causes = 0;
  for (const Cause& one : known) {
    const std::uint64_t ticks = ticks_of(account.gate.withheld, one.cause);
    if (ticks == 0) continue;
    found.reason = ++causes == 1 ? one.reason : NoForceReason::mixed;
    found.count += ticks;
    found.text += fmt::format("{}{} at {} of {} ticks that asked for one", found.text.empty() ? "" : "; ", one.text,
                              ticks, account.gate.wanted);
  }
  if (causes > 0) return found;
  const std::uint64_t early = ticks_of(account.gate.withheld, SafetyCause::not_permitted);
  return {
      {},
      NoForceReason::not_permitted,
      early,
      account.gate.wanted,
      fmt::format("the run let no device engage at {} of {} ticks that asked for a force", early, account.gate.wanted)};
}

/// What braked the handle, where that was so.
std::string brake_text(const GateAccount& gate) {
  return gate.braked == 0 ? "" : fmt::format(", but for the brake at {} ticks", gate.braked);
}

std::optional<NoForce> no_force_of(const ForceAccount& account, const Upstream& upstream, std::size_t device,
                                   bool touched) {
  const GateAccount& gate = account.gate;
  const auto counted = [&](NoForceReason reason, std::uint64_t count, std::string text) {
    return NoForce{{}, reason, count, gate.ticks, std::move(text)};
  };
  const auto found = [&](NoForceReason reason, std::string text) {
    return counted(reason, gate.ticks, std::move(text));
  };
  const auto always = [&](std::uint64_t ticks) { return ticks >= gate.ticks; };
  const auto present = [&](SafetyCause cause) { return ticks_of(gate.present, cause); };
  if (gate.forced > 0) {
    if (account.carried.value_or(1) > 0) return std::nullopt;
    return NoForce{
        {},
        NoForceReason::line,
        gate.forced,
        gate.ticks,
        fmt::format("the gate let one through at {} ticks, and the line to the device carried none", gate.forced)};
  }
  if (gate.ticks == 0) return found(NoForceReason::never_ticked, "the device never ticked");
  // What the device itself lacks comes before what nobody did with it.
  const std::uint64_t not_ready = present(SafetyCause::device_not_ready), unread = present(SafetyCause::read_failed);
  if (always(not_ready)) {
    return found(NoForceReason::device_not_ready, fmt::format("the device showed no position in {} ticks", gate.ticks));
  }
  if (always(not_ready + unread)) {
    return counted(NoForceReason::read_failed, unread,
                   fmt::format("the device could not be read at {} of {} ticks", unread, gate.ticks));
  }
  // A failed write shows at the tick after it.
  if (const std::uint64_t unwritten = present(SafetyCause::write_failed); unwritten > 0 && always(unwritten + 1)) {
    return counted(NoForceReason::write_failed, unwritten,
                   fmt::format("the device took no wrench at {} of {} ticks", unwritten, gate.ticks));
  }
  if (always(present(SafetyCause::dead_man))) {
    return found(NoForceReason::dead_man, fmt::format("button {} was never held", account.dead_man_button));
  }
  if (always(present(SafetyCause::outside_workspace))) {
    return found(NoForceReason::outside_workspace, "the handle was never inside the device's workspace");
  }
  if (!account.fed) return found(NoForceReason::not_fed, "no edge ends at its input segment");
  if (account.segments == 0 || gate.wanted == 0) {
    if (const auto refused = upstream.refused(device)) return refused;
  }
  if (account.segments == 0) return upstream.silent(device);
  const auto of_segments = [&](NoForceReason reason, std::uint64_t count, const char* why) {
    return NoForce{
        {}, reason, count, account.segments, fmt::format("{} of {} forces {}", count, account.segments, why)};
  };
  if (account.refused == account.segments) {
    return of_segments(NoForceReason::segments_refused, account.refused, "refused: their times cannot be");
  }
  if (account.refused + account.not_fresh == account.segments) {
    return of_segments(NoForceReason::segments_not_fresh, account.not_fresh,
                       "not fresh: made from a sample older than sample_age_max, or sent more than stale_after ago");
  }
  if (always(present(SafetyCause::not_permitted))) {
    return found(NoForceReason::not_permitted, "the run ended before it let devices engage");
  }
  if (gate.wanted == 0) {
    return touched ? found(NoForceReason::not_asked, fmt::format("none was asked for in {} ticks", gate.ticks))
                   : found(NoForceReason::no_contact, fmt::format("no contact in {} ticks", gate.ticks));
  }
  if (gate.no_room == gate.wanted) {
    return NoForce{
        {},
        NoForceReason::no_room,
        gate.no_room,
        gate.wanted,
        fmt::format("the largest force is 0 N at {} of {} ticks that asked for one", gate.no_room, gate.wanted)};
  }
  return withheld(account);
}

}  // namespace

std::string_view name_of(NoForceReason reason) {
  static constexpr std::array<std::string_view, 21> names{"never_ticked",
                                                          "device_not_ready",
                                                          "read_failed",
                                                          "write_failed",
                                                          "dead_man",
                                                          "outside_workspace",
                                                          "not_fed",
                                                          "results_refused",
                                                          "no_result",
                                                          "segments_refused",
                                                          "segments_not_fresh",
                                                          "not_permitted",
                                                          "no_room",
                                                          "not_finite",
                                                          "overspeed",
                                                          "time_reversed",
                                                          "stale",
                                                          "mixed",
                                                          "line",
                                                          "no_contact",
                                                          "not_asked"};
  return names[static_cast<std::size_t>(reason)];
}

std::vector<NoForce> devices_without_force(const PlanNodes& nodes, const std::vector<EdgeStatistics>& edges,
                                           const std::vector<std::uint64_t>& steps, bool touched) {
  const Upstream upstream(nodes, edges, steps);
  std::vector<NoForce> found;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const auto* device = dynamic_cast<const DeviceNode*>(&nodes[n]);
    if (device == nullptr) continue;
    const ForceAccount account = device->account();
    std::optional<NoForce> one = no_force_of(account, upstream, n, touched);
    if (!one) continue;
    one->device = nodes.plan().nodes[n].name;
    one->text += brake_text(account.gate);
    found.push_back(std::move(*one));
  }
  return found;
}

}  // namespace tactor
