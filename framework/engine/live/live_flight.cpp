#include "framework/engine/live/live_flight.hpp"

#include <algorithm>
#include <exception>

#include "framework/graph/chains.hpp"
#include "framework/realtime/flight_log.hpp"

namespace tactor {

namespace {

constexpr double flight_seconds = 60;
constexpr double room_for_events = 4096;  // records
constexpr double most_records = 400'000;  // 51 MB
/// Outside of the loops there is time to look at more numbers: those of a set of contacts.
constexpr std::size_t most_numbers_of_step = 8192;

bool wants_flight(const Plan& plan) {
  const FlightChoice choice = plan.graph.live.flight;
  if (choice != FlightChoice::automatic) return choice == FlightChoice::keep;
  return std::any_of(plan.nodes.begin(), plan.nodes.end(),
                     [](const NodeSpec& node) { return node.info->hardware.has_value(); });
}

bool steps_in_loop(const NodeSpec& node) {
  return node.scheduling.lane == Lane::realtime && node.rate().has_value();
}

std::vector<FlightNode> flight_nodes(const Plan& plan) {
  const Chains chains = find_chains(plan);
  std::vector<FlightNode> nodes;
  for (const NodeSpec& spec : plan.nodes) {
    nodes.push_back({spec.name, spec.info->type, steps_in_loop(spec) ? *spec.rate() : 0.0, {}});
  }
  for (std::size_t e = 0; e < plan.edges.size(); ++e) {
    const PlannedEdge& edge = plan.edges[e];
    nodes[edge.to].inputs.push_back({plan.nodes[edge.from].name, edge.spec.to_port, !chains.inner[e]});
  }
  return nodes;
}

/// A record a tick of each node in a loop, and as many for the line of hardware.
std::uint64_t records_for(const Plan& plan) {
  double records = room_for_events;
  for (const NodeSpec& spec : plan.nodes) {
    if (!steps_in_loop(spec)) continue;
    records += flight_seconds * *spec.rate() * (spec.info->hardware ? 2 : 1);
  }
  return static_cast<std::uint64_t>(std::min(records, most_records));
}

}  // namespace

LiveFlight::LiveFlight(const Plan& plan) : plan_(plan) {
  if (!wants_flight(plan)) return;
  try {
    file_.emplace(
        plan.graph.name,
        FlightRing::Description{TACTOR_VERSION, flight_names(plan.graph.name, flight_nodes(plan)), records_for(plan)});
  } catch (const RunError& error) {
    refused_ = std::string("there is no flight recorder: ") + error.what();
    return;
  }
  if (plan.graph.live.flight == FlightChoice::keep) file_->ask_to_keep();
  for (const NodeSpec& spec : plan.nodes) watches_.emplace_back(spec.info->outputs, most_numbers_of_step);
  stalled_.resize(plan.nodes.size());
}

void LiveFlight::start(Instant origin) {
  if (!file_) return;
  ring()->set_origin(origin);
  crash_.emplace(*ring());
}

void LiveFlight::stepped(std::size_t node, PlanNodes& nodes) {
  if (!file_) return;
  const std::vector<OutputInfo>& outputs = plan_.nodes[node].info->outputs;
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const OutputBase& output = outputs[o].access(nodes[node]);
    for (std::size_t i = 0; i < output.pending(); ++i) watches_[node].look(o, output.pending_value(i));
  }
  if (const auto output = watches_[node].take()) {
    ring()->tell(FlightEvent::not_finite, node, MonotonicClock::now(), outputs[*output].name);
  }
}

void LiveFlight::watch(std::size_t node, bool stalled, Time begun) {
  if (!file_ || stalled_[node] == stalled) return;
  stalled_[node] = stalled;
  if (!stalled) return ring()->tell(FlightEvent::came_back, node, MonotonicClock::now(), "");
  ring()->tell(FlightEvent::stalled, node, ring()->origin() + (begun - Time{}), "its step has not come back");
  ring()->note_fault();
}

void LiveFlight::set(const SetEvent& event) {
  if (!file_) return;
  const std::string_view text(reinterpret_cast<const char*>(event.text.data()), static_cast<std::size_t>(event.length));
  ring()->tell(FlightEvent::setting, static_cast<std::size_t>(event.node), MonotonicClock::now(), text);
}

void LiveFlight::failed(const std::string& why, std::optional<std::size_t> node) {
  if (!file_) return;
  ring()->tell(FlightEvent::failed, node.value_or(FlightRecord::no_node), MonotonicClock::now(), why);
  ring()->note_fault();
}

void LiveFlight::end(bool failed) {
  if (!file_) return;
  crash_.reset();
  ring()->set_end(failed ? FlightEnd::failed : FlightEnd::well);
}

}  // namespace tactor
