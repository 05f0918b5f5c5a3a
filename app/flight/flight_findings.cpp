#include "app/flight/flight_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "framework/core/messages.hpp"
#include "framework/realtime/safety_gate.hpp"

namespace tactor {

namespace {

constexpr std::array<std::string_view, 16> fault_names{
    "crashed",     "killed",  "stalled",   "failed",    "line_failed", "device_failed", "not_finite", "too_fast",
    "late_result", "expired", "long_step", "late_wake", "outside",     "other_cut",     "energy",     "limited"};

constexpr Duration near_by{1'000'000'000};  // between a cause and what follows from it
constexpr double late_periods = 3;          // a loop that wakes later than that is told
constexpr Duration late_at_least{2'000'000};
constexpr Duration expiry_is_told{100'000'000};  // by the line, after it happened
constexpr int limited_ticks = 10;                // in a row

double norm_of(const FlightVector& v) {
  return std::sqrt(static_cast<double>(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
}

/// A record of one kind.
template <class Body>
struct TimedBody {
  Time time;
  Body body;
};

/// The records of one kind and node, in order.
template <class Body>
std::vector<TimedBody<Body>> track_of(const FlightLog& log, FlightKind kind, std::size_t node) {
  std::vector<TimedBody<Body>> track;
  for (const FlightRecord& record : log.records) {
    if (record.kind == kind && record.node == node) track.push_back({log.time_of(record), body_of<Body>(record)});
  }
  return track;
}

/// Collects the findings of a log.
class FaultSearch {
 public:
  FaultSearch(const FlightLog& log, bool is_running) : log_(log), is_running_(is_running), events_(log.events()) {}

  std::vector<FlightFinding> all() {
    for (std::size_t n = 0; n < log_.nodes.size(); ++n) {
      const auto device = track_of<FlightDevice>(log_, FlightKind::device, n);
      look_at_ticks(n, device);
      look_at_ticks(n, track_of<FlightTick>(log_, FlightKind::tick, n));
      look_at_gate(n, device);
      look_at_limits(n, device);
      look_at_energy(n, device);
    }
    look_at_events();
    look_at_end();
    return sorted();
  }

 private:
  using Devices = std::vector<TimedBody<FlightDevice>>;
  using Exchanges = std::vector<TimedBody<FlightExchange>>;

  /// A finding, once; it may be changed until the next one comes.
  FlightFinding& found(FlightFault fault, std::size_t node, Time time, std::string words) {
    const std::string name = log_.name_of(static_cast<std::uint16_t>(node));
    const auto same = [&](const FlightFinding& other) {
      return other.fault == fault && other.node == name && other.time == time;
    };
    const auto before = std::find_if(found_.begin(), found_.end(), same);
    if (before != found_.end()) return *before;
    found_.push_back({fault, name, time, std::move(words)});
    return found_.back();
  }
  void add(FlightFault fault, std::size_t node, Time time, std::string words) {
    found(fault, node, time, std::move(words));
  }
  /// One that cut the force.
  void cut(FlightFault fault, std::size_t node, Time time, std::string words) {
    found(fault, node, time, std::move(words)).cut_force = true;
  }
  /// One that ended the run.
  void end(FlightFault fault, std::size_t node, Time time, std::string words) {
    found(fault, node, time, std::move(words)).ended_run = true;
  }
  FlightFinding& late_wake(std::size_t node, Time due, double late_s) {
    FlightFinding& one =
        found(FlightFault::late_wake, node, due, fmt::format("its loop woke {:.1f} ms late", late_s * 1e3));
    one.size_s = late_s;
    return one;
  }
  FlightFinding& long_step(std::size_t node, Time begun, double took_s) {
    FlightFinding& one = found(FlightFault::long_step, node, begun, fmt::format("a step took {:.1f} ms", took_s * 1e3));
    one.size_s = took_s;
    return one;
  }

  /// The event of that kind that is nearest to `time`, at most near_by away; null: there is none.
  [[nodiscard]] const FlightWords* event_near(FlightEvent event, Time time,
                                              std::optional<std::size_t> node = {}) const {
    const FlightWords* nearest = nullptr;
    for (const FlightWords& one : events_) {
      if (one.event != event || (node && one.node != *node)) continue;
      const auto away = [time](const FlightWords& other) { return std::abs((other.time - time).ns); };
      if (away(one) <= near_by.ns && (nearest == nullptr || away(one) < away(*nearest))) nearest = &one;
    }
    return nearest;
  }

  [[nodiscard]] Duration period_of(std::size_t node) const {
    return Duration::from_rate(std::max(1.0, log_.nodes[node].rate_hz));
  }

  /// The latest wake-up and the longest step of a loop, where they are worth a word.
  template <class Ones>
  void look_at_ticks(std::size_t node, const Ones& ticks) {
    const double worth = std::max(late_periods * period_of(node).seconds(), late_at_least.seconds());
    std::optional<std::size_t> latest, longest;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      if (ticks[i].body.body_s > worth && (!longest || ticks[i].body.body_s > ticks[*longest].body.body_s)) longest = i;
      const bool was_long = i > 0 && ticks[i - 1].body.body_s > period_of(node).seconds() / 2;
      if (was_long || ticks[i].body.lateness_s <= worth) continue;
      if (!latest || ticks[i].body.lateness_s > ticks[*latest].body.lateness_s) latest = i;
    }
    // Every node of a chain has the wake-up of their loop.
    const bool is_told = std::any_of(found_.begin(), found_.end(), [&](const FlightFinding& one) {
      return one.fault == FlightFault::late_wake && latest &&
             std::abs((one.time - due_of(node, ticks[*latest])).ns) < 1'000'000;
    });
    if (latest && !is_told) late_wake(node, due_of(node, ticks[*latest]), ticks[*latest].body.lateness_s);
    if (longest) long_step(node, ticks[*longest].time, ticks[*longest].body.body_s);
  }

  /// The first deadline for which a tick was late: its record has the time of the last one before the loop woke.
  template <class One>
  [[nodiscard]] Time due_of(std::size_t node, const One& tick) const {
    const Duration period = period_of(node);
    return tick.time - period * static_cast<std::int64_t>(std::max(0.0F, tick.body.lateness_s) / period.seconds());
  }

  /// Times at which the gate began to keep a force out.
  void look_at_gate(std::size_t node, const Devices& ticks) {
    bool was_open = false;  // since the last cut
    std::uint8_t before = 0;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      const FlightDevice& tick = ticks[i].body;
      const auto cause = static_cast<SafetyCause>(tick.cause);
      const bool is_fault = tick.engagement == static_cast<std::uint8_t>(Engagement::fault);
      if (tick.engagement == static_cast<std::uint8_t>(Engagement::engaged)) was_open = true;
      const bool begins = tick.cause != before && tick.cause != 0;
      before = tick.cause;
      if (!begins || cause == SafetyCause::not_permitted || (!was_open && !is_fault)) continue;
      explain_cut(node, ticks, i, cause);
    }
  }

  void explain_cut(std::size_t node, const Devices& ticks, std::size_t i, SafetyCause cause) {
    const Time time = ticks[i].time;
    switch (cause) {
      case SafetyCause::read_failed:
      case SafetyCause::write_failed:
        return explain_failed_device(node, time, cause);
      case SafetyCause::stale:
        return explain_late_result(node, ticks, i);
      case SafetyCause::not_finite:
        return explain_not_finite(node, time);
      case SafetyCause::overspeed:
        return cut(FlightFault::too_fast, node, time,
                   fmt::format("the handle moved at {:.2f} m/s, and the gate braked it", norm_of(ticks[i].body.v_WD)));
      case SafetyCause::outside_workspace:
        return cut(FlightFault::outside, node, time, "the handle left the workspace, and the gate let go");
      case SafetyCause::expired:
        return explain_expired(node, ticks, i);
      case SafetyCause::time_gap:
      case SafetyCause::time_reversed:
        return explain_gap(node, ticks, i);
      case SafetyCause::dead_man:
        return cut(FlightFault::other_cut, node, time, "the dead-man button was released");
      default:
        return cut(FlightFault::other_cut, node, time, fmt::format("the gate let go: {}", name_of(cause)));
    }
  }

  /// A tick that came late or a step that took long, as the ticks tell it.
  void explain_gap(std::size_t node, const Devices& ticks, std::size_t i) {
    const bool was_long = i > 0 && ticks[i - 1].body.body_s > period_of(node).seconds() / 2;
    FlightFinding& one = was_long ? long_step(node, ticks[i - 1].time, ticks[i - 1].body.body_s)
                                  : late_wake(node, due_of(node, ticks[i]), ticks[i].body.lateness_s);
    one.cut_force = true;
  }

  /// The latest of the ticks in the time before `i`, where it woke or the step before took longer than half of that.
  [[nodiscard]] std::optional<std::size_t> gap_before(const Devices& ticks, std::size_t i, double within_s) const {
    std::optional<std::size_t> latest;
    for (std::size_t at = i + 1; at-- > 0 && (ticks[i].time - ticks[at].time).seconds() <= within_s;) {
      const double late = ticks[at].body.lateness_s;
      if (late > within_s / 2 && (!latest || late > ticks[*latest].body.lateness_s)) latest = at;
    }
    return latest;
  }

  void explain_expired(std::size_t node, const Devices& ticks, std::size_t i) {
    // A command holds for two periods; a line tells late that one has not been renewed.
    const double held = 2 * period_of(node).seconds();
    for (std::size_t at = i + 1; at-- > 0 && ticks[i].time - ticks[at].time <= expiry_is_told;) {
      if (ticks[at].body.lateness_s > held / 2) return explain_gap(node, ticks, at);
    }
    cut(FlightFault::expired, node, ticks[i].time, "the device let go of a command that was not renewed in time");
  }

  /// The line's failure where there is a line, and the device's own otherwise.
  void explain_failed_device(std::size_t node, Time time, SafetyCause cause) {
    const Exchanges line = track_of<FlightExchange>(log_, FlightKind::exchange, node);
    std::optional<Time> since;  // the first cycle that failed after the last good one
    std::optional<Time> last_good;
    bool is_believed = true;
    for (const auto& one : line) {
      if (one.time > time) break;
      if (one.body.error == 0) {
        since.reset();
        last_good = one.time;
        is_believed = one.body.verdict == 0;
      } else if (!since) {
        since = one.time;
      }
    }
    const FlightWords* told = event_near(FlightEvent::line_failed, since.value_or(time), node);
    if (since || told != nullptr) {
      return cut(FlightFault::line_failed, node, since.value_or(told != nullptr ? told->time : time),
                 told != nullptr ? told->words : "cycles of its line failed");
    }
    const bool is_silent = last_good && (time - *last_good).seconds() > 5 * period_of(node).seconds();
    if (is_silent) return cut(FlightFault::line_failed, node, *last_good, "no cycle of its line came back any more");
    const char* what = cause == SafetyCause::read_failed ? "read" : "written";
    cut(FlightFault::device_failed, node, time,
        is_believed ? fmt::format("the device could not be {}", what) : "its encoders are not believed");
  }

  /// Which result was missing: that of a step that stalled, else of the writer whose newest message is the oldest.
  void explain_late_result(std::size_t node, const Devices& ticks, std::size_t i) {
    const Time time = ticks[i].time;
    if (event_near(FlightEvent::stalled, time) != nullptr) return;  // told by itself
    // A process that was kept from running has no fresh force either.
    if (const auto gap = gap_before(ticks, i, ticks[i].body.result_age_s)) return explain_gap(node, ticks, *gap);
    std::string from;
    double oldest = 0;
    for (std::size_t n = 0; n < log_.nodes.size(); ++n) {
      const auto track = track_of<FlightTick>(log_, FlightKind::tick, n);
      const auto at = std::find_if(track.begin(), track.end(), [time](const auto& one) { return one.time >= time; });
      if (at == track.end()) continue;
      const std::vector<FlightNode::In>& inputs = log_.nodes[n].inputs;
      for (std::size_t in = 0; in < std::min(inputs.size(), FlightTick::most_inputs); ++in) {
        const double age = at->body.input_age_s[in];
        if (!inputs[in].is_outer || !(age > oldest)) continue;
        oldest = age;
        from = inputs[in].from;
      }
    }
    for (const FlightNode::In& in : log_.nodes[node].inputs) {
      if (in.port == "segment" && in.is_outer) from = in.from;
    }
    cut(FlightFault::late_result, from.empty() ? node : index_of(from), time,
        fmt::format("the newest force of {} was {:.0f} ms old, and the gate let go", log_.nodes[node].name,
                    ticks[i].body.result_age_s * 1e3));
  }

  [[nodiscard]] std::size_t index_of(const std::string& name) const {
    const auto found =
        std::find_if(log_.nodes.begin(), log_.nodes.end(), [&](const auto& n) { return n.name == name; });
    return static_cast<std::size_t>(found - log_.nodes.begin());
  }

  void explain_not_finite(std::size_t node, Time time) {
    for (const FlightWords& one : events_) {  // the first is where it came from
      const bool is_cause = one.event == FlightEvent::not_finite && std::abs((one.time - time).ns) <= near_by.ns;
      if (!is_cause) continue;
      return cut(FlightFault::not_finite, one.node, one.time, "its output " + one.words + " was NaN or infinite");
    }
    cut(FlightFault::not_finite, node, time, "the wrench that it was given was NaN or infinite");
  }

  void look_at_limits(std::size_t node, const Devices& ticks) {
    int in_a_row = 0;
    for (const auto& [time, tick] : ticks) {
      const bool engaged = tick.engagement == static_cast<std::uint8_t>(Engagement::engaged);
      const bool is_less = norm_of(tick.commanded_force) < 0.99 * norm_of(tick.wanted_force) - 1e-3;
      in_a_row = engaged && is_less ? in_a_row + 1 : 0;
      if (in_a_row < limited_ticks) continue;
      return add(FlightFault::limited, node, time,
                 fmt::format("{:.2f} N was wanted and {:.2f} N went through", norm_of(tick.wanted_force),
                             norm_of(tick.commanded_force)));
    }
  }

  void look_at_energy(std::size_t node, const Devices& ticks) {
    for (const auto& [time, cycle] : track_of<FlightExchange>(log_, FlightKind::exchange, node)) {
      if (cycle.bounded == 0) continue;
      return add(FlightFault::energy, node, time, "the bound on the energy of its line held efforts back");
    }
    for (const auto& [time, tick] : ticks) {
      if (!(tick.generated_J > tick.allowed_J)) continue;
      return add(FlightFault::energy, node, time, "its motors gave more energy than one step and one cycle can bring");
    }
  }

  void look_at_events() {
    bool any_failed = false;
    for (const FlightWords& one : events_) {
      if (one.event == FlightEvent::crashed) {
        end(FlightFault::crashed, one.node, one.time, "the process got " + one.words);
      } else if (one.event == FlightEvent::stalled) {
        const FlightWords* ended = event_near_after(FlightEvent::failed, one.time, one.node);
        FlightFinding& stalled = found(FlightFault::stalled, one.node, one.time, one.words);
        stalled.cut_force = true;
        stalled.ended_run = ended != nullptr;
      } else if (one.event == FlightEvent::line_failed) {
        const auto is_told = [&](const FlightFinding& other) { return other.words == one.words; };
        if (std::none_of(found_.begin(), found_.end(), is_told)) {
          add(FlightFault::line_failed, one.node, one.time, one.words);
        }
      } else if (one.event == FlightEvent::failed && !std::exchange(any_failed, true)) {
        explain_failure(one);
      }
    }
  }

  [[nodiscard]] const FlightWords* event_near_after(FlightEvent event, Time time, std::size_t node) const {
    const auto is_it = [&](const FlightWords& one) {
      return one.event == event && one.node == node && one.time >= time;
    };
    const auto found = std::find_if(events_.begin(), events_.end(), is_it);
    return found == events_.end() ? nullptr : &*found;
  }

  /// The run's failure belongs to what was found first of its device, where that could not be reached from then on.
  void explain_failure(const FlightWords& failure) {
    const std::string node = log_.name_of(failure.node);
    const Devices ticks = track_of<FlightDevice>(log_, FlightKind::device, failure.node);
    constexpr std::uint8_t read_failed = 2;  // DeviceHealth, and what follows it
    Time failing_since = failure.time;
    for (auto tick = ticks.rbegin(); tick != ticks.rend() && tick->body.health >= read_failed; ++tick) {
      failing_since = tick->time;
    }
    FlightFinding* first = nullptr;
    for (FlightFinding& one : found_) {
      const bool is_its = one.fault == FlightFault::line_failed || one.fault == FlightFault::device_failed;
      const bool is_then = one.time >= failing_since - near_by && one.time <= failure.time;
      if (is_its && is_then && one.node == node && (first == nullptr || one.time < first->time)) first = &one;
    }
    if (failing_since < failure.time && first != nullptr) {
      first->ended_run = true;
      first->words += "; " + failure.words;
      return;
    }
    const auto stalled = [&](const FlightWords& one) {
      return one.event == FlightEvent::stalled && one.node == failure.node && one.time <= failure.time;
    };
    if (std::any_of(events_.begin(), events_.end(), stalled)) return;
    end(FlightFault::failed, failure.node, failure.time, failure.words);
  }

  void look_at_end() {
    const bool crashed = std::any_of(found_.begin(), found_.end(),
                                     [](const FlightFinding& one) { return one.fault == FlightFault::crashed; });
    if (is_running_ || crashed || log_.end != FlightEnd::none) return;
    std::string words = "the process ended without a word, as by SIGKILL or where memory is short";
    for (std::size_t n = 0; n < log_.nodes.size(); ++n) {
      const Devices ticks = track_of<FlightDevice>(log_, FlightKind::device, n);
      if (ticks.empty()) continue;
      words += fmt::format("; {} had {:.2f} N", log_.nodes[n].name, norm_of(ticks.back().body.commanded_force));
    }
    end(FlightFault::killed, FlightRecord::no_node, log_.last(), words);
  }

  /// The fault first, the others by their time.
  std::vector<FlightFinding> sorted() {
    const auto by_time = [](const FlightFinding& a, const FlightFinding& b) { return a.time < b.time; };
    std::stable_sort(found_.begin(), found_.end(), by_time);
    const auto graver = [](const FlightFinding& a, const FlightFinding& b) {
      const auto rank = [](const FlightFinding& one) {
        return std::tuple(!one.ended_run, !one.cut_force, one.fault, -one.size_s);
      };
      return rank(a) < rank(b);
    };
    const auto fault = std::min_element(found_.begin(), found_.end(), graver);
    if (fault != found_.end()) std::rotate(found_.begin(), fault, fault + 1);
    return std::move(found_);
  }

  const FlightLog& log_;
  const bool is_running_;
  const std::vector<FlightWords> events_;
  std::vector<FlightFinding> found_;
};

}  // namespace

std::string_view name_of(FlightFault fault) {
  return fault_names[static_cast<std::size_t>(fault)];
}

std::vector<FlightFinding> find_faults(const FlightLog& log, bool is_running) {
  return FaultSearch(log, is_running).all();
}

}  // namespace tactor
