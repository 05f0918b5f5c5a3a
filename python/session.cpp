#include "python/session.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/run/run_metrics.hpp"
#include "framework/core/message_json.hpp"
#include "framework/core/units.hpp"
#include "framework/graph/plan_metrics.hpp"
#include "framework/node/report.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/yaml/yaml_values.hpp"
#include "python/errors.hpp"
#include "python/file_text.hpp"
#include "python/message_arrays.hpp"
#include "python/run_result.hpp"

namespace tactor::python {

namespace py = pybind11;
using namespace py::literals;

Duration duration_of(const py::object& given, const std::string& what) {
  const std::string expected = what + ": expected a number of seconds or a text such as \"10 ms\", found ";
  double seconds = 0;
  if (py::isinstance<py::str>(given)) {
    const std::string text = given.cast<std::string>();
    const auto parsed = parse_quantity(text);
    if (const auto* why = std::get_if<std::string>(&parsed)) throw InputError(expected + text + ": " + *why);
    const auto& quantity = std::get<Quantity>(parsed);
    if (quantity.dimension != Dimension{.s = 1}) throw InputError(expected + text);
    seconds = quantity.value_si;
  } else {
    try {
      seconds = given.cast<double>();
    } catch (const py::cast_error&) {
      throw InputError(expected + py::cast<std::string>(py::repr(given)));
    }
  }
  if (!(seconds >= 0 && seconds <= longest_time_s)) {
    throw InputError(fmt::format("{}: expected a time of 0 s to {:g} s, found {:g} s", what, longest_time_s, seconds));
  }
  return Duration::from_seconds(seconds);
}

namespace {

/// How long Python waits for its signals.
constexpr Duration attend_period{20'000'000};
/// The longest part of a run that passes in one go.
constexpr Duration longest_slice{10'000'000};

}  // namespace

SessionState::SessionState(const Graph& graph, const SessionOptions& options)
    : registry_(graph.registry()),
      session_(std::make_unique<Session>(graph.plan(), options)),
      live_(graph.plan().graph.clock == Clock::real),
      slice_(!live_ && options.engine.pace > 0
                 ? std::min(longest_slice, Duration::from_seconds(attend_period.seconds() * options.engine.pace))
                 : longest_slice) {}

SessionState::~SessionState() {
  if (is_foreign()) {
    static_cast<void>(session_.release());
    static_cast<void>(new std::shared_ptr<Registry>(std::move(registry_)));
    return;
  }
  // Where it still runs it ends here, and its nodes may be Python's own.
  without_lock(
      [this] {
        const bool abandoned = session_->is_abandoned();
        session_.reset();
        // A step that never came back still uses the declarations.
        if (abandoned) static_cast<void>(new std::shared_ptr<Registry>(std::move(registry_)));
      },
      live_);
}

void SessionState::forget(Session::Subscribed messages) {
  const std::scoped_lock lock(forgotten_lock_);
  forgotten_.push_back(messages);
}

void SessionState::end_forgotten() {
  const std::scoped_lock lock(forgotten_lock_);
  for (const Session::Subscribed messages : std::exchange(forgotten_, {})) session_->end_messages(messages);
}

void SessionState::demand_running(const char* what) const {
  if (finished_) throw RunError(std::string(what) + ": the session has finished");
  if (!started_) throw RunError(std::string(what) + ": the session has not started; call start() or advance() first");
}

void SessionState::start() {
  use([this](Session& session) {
    if (finished_) throw RunError("start: the session has finished");
    if (started_) throw RunError("start: the session has started already");
    session.start();
    started_ = true;
  });
}

void SessionState::advance(Duration duration) {
  advance_while("advance", [this, left = duration](Session& session) mutable {
    const Duration part = std::min(left, slice_);
    session.advance(part);
    left = left - part;
    return left > Duration{} && session.is_running();
  });
}

void SessionState::advance_while(const char* what, const std::function<bool(Session&)>& part) {
  if (!started_ && !finished_) start();
  for (bool goes_on = true; goes_on;) {
    // Slices of the run until it is time to look for signals.
    use([&](Session& session) {
      demand_running(what);
      if (failed_) throw RunError(std::string(what) + ": the run has failed before");
      const Instant until = MonotonicClock::now() + attend_period;
      try {
        do {
          goes_on = part(session);
        } while (goes_on && MonotonicClock::now() < until);
      } catch (...) {
        failed_ = true;
        throw;
      }
    });
    try {
      check_signals();
    } catch (const py::error_already_set&) {
      // A live run does not go on without who looks after it: its devices ramp down first.
      if (live_) {
        use([this](Session& session) {
          session.stop();
          finish_now(session);
        });
      }
      throw;
    }
  }
}

void SessionState::finish_now(Session& session) {
  if (!started_ || finished_) return;
  finished_ = true;
  session.finish();
}

std::optional<std::string> SessionState::finish() {
  return use([this](Session& session) -> std::optional<std::string> {
    if (finished_) return {};
    if (!started_) {
      finished_ = true;
      return {};
    }
    finish_now(session);
    return session.failure();
  });
}

void SessionState::stop() {
  use([this](Session& session) {
    demand_running("stop");
    session.stop();
  });
}

bool SessionState::is_running() {
  return use([this](Session& session) { return !finished_ && (!started_ || session.is_running()); });
}

double SessionState::now() {
  return use([this](Session& session) {
    if (!started_) return 0.0;
    return session.now().seconds();
  });
}

namespace {

/// A tap grows as messages come, so that only the count is bounded: its product with the size of a message has to fit.
constexpr std::uint64_t most_in_tap = std::uint64_t{1} << 24U;

/// A tap of Python's. It may outlive its session, of which it then has what came last.
class PythonTap {
 public:
  PythonTap(const std::shared_ptr<SessionState>& session, std::string output, std::uint64_t queue)
      : session_(session), output_(std::move(output)) {
    if (queue > most_in_tap) {
      throw InputError(
          fmt::format("tap: expected a queue of at most {} messages, or none, found {}", most_in_tap, queue));
    }
    session->use([&](Session& running) {
      if (session->is_finished()) throw RunError("tap: the session has finished");
      buffer_ = std::make_shared<TapBuffer>(type_of(running.plan(), find_output(running.plan(), output_)), queue);
      messages_ = running.on_message(
          output_, [buffer = buffer_](const Stamp& stamp, const void* value) { buffer->put(stamp, value); });
    });
    arrays_ = std::make_unique<MessageArrays>(buffer_->type());
  }
  PythonTap(const PythonTap&) = delete;
  PythonTap& operator=(const PythonTap&) = delete;
  ~PythonTap() {
    buffer_->close();
    // The collector of garbage may be here in a step of this very session.
    if (const auto session = session_.lock()) session->forget(messages_);
  }

  [[nodiscard]] const std::string& output() const { return output_; }
  [[nodiscard]] std::string description() const { return to_documented_json(buffer_->type()); }
  [[nodiscard]] const py::dtype& dtype() const { return arrays_->message_dtype(); }
  [[nodiscard]] std::uint64_t dropped() const { return buffer_->dropped(); }

  py::array take() {
    // Live, what came since the last advance still waits in the session.
    if (const auto session = session_.lock(); session && session->is_live() && session->is_started()) {
      session->use([&](Session& running) {
        if (!session->is_finished()) running.advance({});
      });
    }
    return arrays_->take(buffer_->take());
  }

 private:
  std::weak_ptr<SessionState> session_;
  std::string output_;
  std::shared_ptr<TapBuffer> buffer_;
  Session::Subscribed messages_{};
  std::unique_ptr<MessageArrays> arrays_;
};

class PythonFeed {
 public:
  PythonFeed(const std::shared_ptr<SessionState>& session, std::string name)
      : session_(session), name_(std::move(name)) {
    session->use([&](Session& running) {
      if (session->is_finished()) throw RunError("feed: the session has finished");
      feed_ = running.feed(name_);
    });
    arrays_ = std::make_unique<MessageArrays>(feed_->type());
  }

  [[nodiscard]] std::string description() const { return to_documented_json(feed_->type()); }
  [[nodiscard]] const py::dtype& dtype() const { return arrays_->value_dtype(); }

  bool send(const py::object& value, const py::object& valid) {
    const auto session = session_.lock();
    if (!session) throw RunError("send: the session of this feed is gone");
    const OwnedValue message = arrays_->value_of(value, "send to " + name_);
    std::optional<Time> at;
    if (!valid.is_none()) at = Time{} + duration_of(valid, "send to " + name_ + ": valid");
    return session->use([&](Session&) {
      session->demand_running("send");
      return feed_->send(message.data(), at);
    });
  }

 private:
  std::weak_ptr<SessionState> session_;
  std::string name_;
  std::optional<Session::Feed> feed_;
  std::unique_ptr<MessageArrays> arrays_;
};

py::dict status_of(SessionState& state) {
  constexpr const char* phases[]{"starting", "running", "stopping"};
  if (!state.is_live()) throw InputError("status: expected a session whose clock is real, found clock: virtual");
  if (!state.is_started()) throw RunError("status: the session has not started");
  std::vector<std::string> names;
  const EngineStatus status = state.use([&](Session& session) {
    for (const NodeSpec& node : session.plan().nodes) names.push_back(node.name);
    return session.status();
  });
  py::dict nodes, devices;
  for (std::size_t i = 0; i < status.nodes.size(); ++i) {
    const NodeStatus& node = status.nodes[i];
    nodes[py::str(names[i])] =
        py::dict("steps"_a = node.steps, "missed_ticks"_a = node.missed_ticks, "stalled"_a = node.stalled);
  }
  for (const DeviceStatus& device : status.devices) {
    devices[py::str(names[device.node])] =
        py::dict("ticks"_a = device.ticks, "missed"_a = device.missed, "dropped"_a = device.dropped,
                 "wakeup_us_p99"_a = device.wake_latency.p99.microseconds(),
                 "body_us_p99"_a = device.body_time.p99.microseconds());
  }
  return py::dict("now_s"_a = status.now.seconds(), "phase"_a = phases[static_cast<std::size_t>(status.phase)],
                  "waiting_for"_a = status.waiting_for, "nodes"_a = nodes, "devices"_a = devices,
                  "missing_privileges"_a = status.missing);
}

/// What the nodes report of the run so far, without what needs a reference run.
py::list metrics_of(SessionState& state) {
  if (state.is_live() && !state.is_finished()) {
    throw RunError("metrics: a run whose clock is real has them once it has finished");
  }
  Report report;
  MetricMap declared;
  state.use([&](Session& session) {
    if (session.is_abandoned()) throw RunError("metrics: a step never came back, so that its node cannot be asked");
    declared = run_metrics(session.plan(), false).reported;
    for (std::size_t i = 0; i < session.plan().nodes.size(); ++i) {
      report.ask(session.nodes()[i], session.plan().nodes[i].name, node_metrics(session.plan(), i, false).reported);
    }
  });
  return metric_list(report.metrics(), declared);
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<PythonTap, std::shared_ptr<PythonTap>>(module, "Tap")
      .def_property_readonly("output", &PythonTap::output)
      .def_property_readonly("description", &PythonTap::description)
      .def_property_readonly("dtype", &PythonTap::dtype)
      .def_property_readonly("dropped", &PythonTap::dropped)
      .def("take", &PythonTap::take);
  py::class_<PythonFeed, std::shared_ptr<PythonFeed>>(module, "Feed")
      .def_property_readonly("description", &PythonFeed::description)
      .def_property_readonly("dtype", &PythonFeed::dtype)
      .def("send", &PythonFeed::send, py::arg("value"), py::arg("valid") = py::none());
  py::class_<SessionState, std::shared_ptr<SessionState>>(module, "Session")
      .def(py::init([](const Graph& graph, double pace, bool measure_cpu, bool no_dead_man) {
             constexpr double lowest_pace = 1e-6;
             if (!(pace == 0 || pace >= lowest_pace) || std::isinf(pace)) {
               throw InputError(
                   fmt::format("pace: expected 0, or seconds of the run for a second, at least {:g}, found {:g}",
                               lowest_pace, pace));
             }
             return without_lock([&] {
               return std::make_shared<SessionState>(
                   graph,
                   SessionOptions{.engine = {.measure_cpu = measure_cpu,
                                             .pace = pace,
                                             .without_dead_man = [=](const std::string&) { return no_dead_man; }},
                                  .keeps_tables = true});
             });
           }),
           py::arg("graph"), py::arg("pace") = 0.0, py::arg("measure_cpu") = false, py::arg("no_dead_man") = false)
      .def("start", &SessionState::start)
      .def(
          "advance",
          [](SessionState& state, const py::object& duration) { state.advance(duration_of(duration, "advance")); },
          py::arg("duration"))
      .def("finish",
           [](SessionState& state) -> py::object {
             const std::optional<std::string> failure = state.finish();
             if (!failure) return py::none();
             return python_text(*failure);
           })
      .def("stop", &SessionState::stop)
      .def_property_readonly("running", &SessionState::is_running)
      .def_property_readonly("now", &SessionState::now)
      .def_property_readonly("live", &SessionState::is_live)
      .def_property_readonly("started", &SessionState::is_started)
      .def_property_readonly("finished", &SessionState::is_finished)
      .def_property_readonly(
          "dropped", [](SessionState& state) { return state.use([](Session& session) { return session.dropped(); }); })
      .def("notes",
           [](SessionState& state) {
             return python_texts(state.use([](Session& session) { return session.nodes().notes(); }));
           })
      .def(
          "tap",
          [](const std::shared_ptr<SessionState>& state, const std::string& output, std::uint64_t queue) {
            return std::make_shared<PythonTap>(state, output, queue);
          },
          py::arg("output"), py::arg("queue") = 0)
      .def(
          "feed",
          [](const std::shared_ptr<SessionState>& state, const std::string& name) {
            return std::make_shared<PythonFeed>(state, name);
          },
          py::arg("name"))
      .def(
          "set",
          [](SessionState& state, const std::string& parameter, const std::string& value) {
            state.use([&](Session& session) {
              state.demand_running("set");
              session.set(parameter, value);
            });
          },
          py::arg("parameter"), py::arg("value"))
      .def("status", status_of)
      .def("metrics", metrics_of);
}

}  // namespace tactor::python
