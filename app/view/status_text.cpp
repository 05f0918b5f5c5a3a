#include "app/view/status_text.hpp"

#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "app/run/felt_text.hpp"

namespace tactor {

namespace {

using nlohmann::json;

constexpr Duration status_period{250'000'000};

const char* word(Phase phase) {
  switch (phase) {
    case Phase::starting:
      return "starting";
    case Phase::running:
      return "running";
    case Phase::stopping:
      return "stopping";
  }
  return "";
}

json reference_object(const FollowerFigures& figures) {
  json object = {{"behind", figures.behind.seconds()}};
  if (figures.error.compared > 0) {
    object["rms"] = figures.error.rms_N;
    object["max"] = figures.error.max_N;
  }
  if (figures.felt) {
    const FeltShare share{"force", figures.felt->beyond_weber};
    object["felt"] = felt_text(std::span(&share, 1), figures.felt->vibration);
  }
  if (figures.error.delay) object["delay"] = figures.error.delay->seconds();
  return object;
}

json device_object(const DeviceStatus& device) {
  return {{"ticks", device.ticks},
          {"missed", device.missed},
          {"wakeup_p50", device.wake_latency.p50.seconds()},
          {"wakeup_p99", device.wake_latency.p99.seconds()},
          {"wakeup_max", device.wake_latency.max.seconds()},
          {"page_faults", device.page_faults}};
}

}  // namespace

StatusText::StatusText(Session& session, const Follower* follower, const StreamTaps& taps, bool blind)
    : session_(session),
      follower_(follower),
      taps_(taps),
      blind_(blind),
      steps_(session.plan().nodes.size()),
      delivered_(session.plan().edges.size()) {}

bool StatusText::is_due(Instant now) const {
  return now - told_ >= status_period;
}

std::string StatusText::next(Instant now, std::optional<Hold> hold) {
  const EngineStatus run = session_.status();
  const bool first = told_.ns == 0;
  const double passed = (run.now - told_at_).seconds();
  const auto rate = [&](std::uint64_t& before, std::uint64_t count) {
    const double steps = static_cast<double>(count - before);
    before = count;
    return passed > 0 ? steps / passed : 0.0;
  };
  json nodes = json::array();
  for (std::size_t n = 0; n < steps_.size(); ++n) {
    const NodeStatus& node = run.nodes[n];
    nodes.push_back({{"rate", rate(steps_[n], node.steps)}, {"missed", node.missed_ticks}, {"stalled", node.stalled}});
  }
  json edges = json::array();
  for (std::size_t e = 0; e < delivered_.size(); ++e) {
    const auto& [metrics, age] = run.edges[e];
    json edge = {{"rate", rate(delivered_[e], metrics.delivered)}, {"dropped", metrics.dropped}};
    if (age.count > 0) edge["age"] = age.p50.seconds();
    edges.push_back(std::move(edge));
  }
  json status = {{"type", "status"},
                 {"now", run.now.seconds()},
                 {"monotonic", static_cast<double>(now.ns) * 1e-9},
                 {"phase", word(run.phase)},
                 {"speed", passed / (now - told_).seconds()},
                 {"nodes", blind_ ? json::array() : std::move(nodes)},
                 {"edges", blind_ ? json::array() : std::move(edges)},
                 {"lost", taps_.dropped()}};
  if (!run.devices.empty()) status["device"] = device_object(run.devices.front());
  if (follower_ != nullptr) status["reference"] = reference_object(follower_->figures());
  if (hold) status["hold"] = name_of(*hold);
  told_ = now;
  told_at_ = run.now;
  // The first look is what rates are counted from.
  return first ? std::string() : status.dump();
}

}  // namespace tactor
