#include "app/view/session_view.hpp"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "app/output.hpp"
#include "app/run/felt_text.hpp"
#include "devices/mouse/cursor.hpp"
#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace {

using nlohmann::json;

constexpr Duration status_period{250'000'000};
/// Between the engine's threads and those that give way to everybody: a page is to follow the hand.
constexpr int server_niceness = 10;
constexpr std::size_t most_requests = 256;

void begin_server_thread() {
  pthread_setname_np(pthread_self(), "view");
  // On Linux it is that of the calling thread. Refused, it stays as it is, which costs nobody anything.
  static_cast<void>(setpriority(PRIO_PROCESS, 0, server_niceness));
}

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

std::optional<std::size_t> node_index(const Plan& plan, const std::optional<std::string>& name) {
  for (std::size_t n = 0; name && n < plan.nodes.size(); ++n) {
    if (plan.nodes[n].name == *name) return n;
  }
  return std::nullopt;
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

bool has_stalled(Session& session) {
  const std::vector<NodeStatus> nodes = session.status().nodes;
  return std::any_of(nodes.begin(), nodes.end(), [](const NodeStatus& node) { return node.stalled; });
}

}  // namespace

SessionView::SessionView(Session& session, Follower* follower, Options options)
    : session_(session),
      follower_(follower),
      options_(std::move(options)),
      taps_(session, follower, experiment_of(session.plan()).has_value()) {
  const Plan& plan = session.plan();
  extras_.duration = plan.graph.duration.seconds();
  extras_.mouse = node_index(plan, options_.mouse);
  extras_.start = options_.start;
  X_WC_ = options_.start;
  experiment_ = experiment_of(plan);
  if (const auto methods = method_switch(plan)) method_parameter_ = methods->parameter;
  if (extras_.mouse) {
    cursor_ = session.feed(*options_.mouse + ".cursor");
    const NodeSpec& mouse = plan.nodes[*extras_.mouse];
    const ParamValue& timeout = mouse.params[mouse.info->param("heartbeat_timeout").value()];
    hold_.emplace(Duration::from_seconds(std::get<double>(timeout)));
  }
  steps_.resize(plan.nodes.size());
  delivered_.resize(plan.edges.size());
  server_ = load_view_library().serve(*this, options_.ports);
  url_ = server_->url();
  thread_ = make_thread("view", [this] {
    begin_server_thread();
    try {
      server_->run();
    } catch (const std::exception& error) {
      const std::scoped_lock lock(mutex_);
      failure_ = error.what();
    }
  });
}

SessionView::~SessionView() {
  server_->stop();
  thread_.join();
}

std::optional<std::string> SessionView::failure() {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

std::string SessionView::hello() {
  HelloExtras extras = extras_;
  {
    const std::scoped_lock lock(mutex_);
    extras.values = values_;
  }
  return hello_text(session_.plan(), taps_.streams(), extras);
}

std::string SessionView::status() {
  const std::scoped_lock lock(mutex_);
  return status_;
}

void SessionView::send_cursor(const Pose& X_WC, bool held) {
  X_WC_ = X_WC;
  Cursor cursor;
  cursor.X_WC = X_WC;
  cursor.held = held ? 1 : 0;
  // The edge is `latest`, which always has room.
  static_cast<void>(cursor_->send(cursor));
}

void SessionView::receive(ClientId client, const ClientMessage& message) {
  const std::scoped_lock lock(mutex_);
  switch (message.kind) {
    case ClientMessage::Kind::input:
      if (!taking_ || !cursor_) return;
      hold_->input(message.held, MonotonicClock::now());
      send_cursor(message.X_WC, message.held);
      return;
    case ClientMessage::Kind::set:
      // A page that asks for more between two looks than anybody can turn has gone wrong.
      if (requests_.size() < most_requests) requests_.push_back({client, message.parameter, message.value});
      return;
    case ClientMessage::Kind::stop:
      stop_asked_ = true;
      if (taking_) session_.stop();
      return;
    case ClientMessage::Kind::ack:
    case ClientMessage::Kind::control:
      return;
  }
}

void SessionView::release() {
  const std::scoped_lock lock(mutex_);
  if (!taking_ || !cursor_) return;
  hold_->page_gone(MonotonicClock::now());
  send_cursor(X_WC_, false);
}

void SessionView::note(const std::string& text) {
  tell_note(text);
}

void SessionView::set(const Request& request) {
  json answer = {{"parameter", request.parameter}, {"client", request.client}};
  try {
    if (experiment_ && request.parameter != *experiment_ + ".answer") {
      throw InputError("the run is a blind experiment: a page answers its questions and changes nothing else");
    }
    session_.set(request.parameter, request.value);
    {
      const std::scoped_lock lock(mutex_);
      values_[request.parameter] = request.value;
    }
    if (follower_ != nullptr && request.parameter == method_parameter_) follower_->count_anew();
    answer["type"] = "set";
    answer["value"] = json::parse(parameter_value_text(session_.plan(), request.parameter, request.value));
    server_->post(answer.dump(), {});
  } catch (const std::exception& error) {
    answer["type"] = "refused";
    answer["message"] = error.what();
    server_->post(answer.dump(-1, ' ', false, json::error_handler_t::replace), request.client);
  }
}

void SessionView::attend() {
  std::vector<Request> requests;
  {
    const std::scoped_lock lock(mutex_);
    taking_ = true;
    requests.swap(requests_);
    // It was asked for before the session began.
    if (stop_asked_) session_.stop();
  }
  for (const Request& request : requests) set(request);
  if (MonotonicClock::now() - told_ < status_period) return;
  std::string text = status_text();
  const std::scoped_lock lock(mutex_);
  status_ = std::move(text);
}

std::string SessionView::status_text() {
  const Instant wall = MonotonicClock::now();
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
                 {"monotonic", static_cast<double>(wall.ns) * 1e-9},
                 {"phase", word(run.phase)},
                 {"speed", passed / (wall - told_).seconds()},
                 {"nodes", experiment_ ? json::array() : std::move(nodes)},
                 {"edges", experiment_ ? json::array() : std::move(edges)},
                 {"lost", taps_.dropped()}};
  if (!run.devices.empty()) status["device"] = device_object(run.devices.front());
  if (follower_ != nullptr) status["reference"] = reference_object(follower_->figures());
  {
    const std::scoped_lock lock(mutex_);
    if (hold_) status["hold"] = name_of(hold_->at(wall));
  }
  told_ = wall;
  told_at_ = run.now;
  // The first look is what rates are counted from.
  return first ? std::string() : status.dump();
}

bool SessionView::was_stopped() {
  const std::scoped_lock lock(mutex_);
  return stop_asked_;
}

RunEnd SessionView::end_of_run(bool failed, bool interrupted) {
  if (failed || session_.failure()) return has_stalled(session_) ? RunEnd::stalled : RunEnd::failed;
  if (was_stopped()) return RunEnd::stopped;
  return interrupted ? RunEnd::interrupted : RunEnd::over;
}

void SessionView::tell_end(RunEnd end, const std::string& why) {
  {
    const std::scoped_lock lock(mutex_);
    taking_ = false;
    status_.clear();
  }
  const json text = {{"type", "ended"}, {"end", name_of(end)}, {"why", why}};
  server_->post(text.dump(-1, ' ', false, json::error_handler_t::replace), {});
}

}  // namespace tactor
