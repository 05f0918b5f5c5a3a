#include "app/view/session_view.hpp"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/output.hpp"
#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace {

using nlohmann::json;

/// Between the engine's threads and those that give way to everybody: a page is to follow the hand.
constexpr int server_niceness = 10;
constexpr std::size_t most_requests = 256;

void begin_server_thread() {
  pthread_setname_np(pthread_self(), "view");
  // On Linux it is that of the calling thread. Refused, it stays as it is, which costs nobody anything.
  static_cast<void>(setpriority(PRIO_PROCESS, 0, server_niceness));
}

std::optional<std::size_t> node_index(const Plan& plan, const std::optional<std::string>& name) {
  for (std::size_t n = 0; name && n < plan.nodes.size(); ++n) {
    if (plan.nodes[n].name == *name) return n;
  }
  return std::nullopt;
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
      experiment_(experiment_of(session.plan())),
      taps_(session, follower, *options_.drawn, experiment_.has_value()),
      status_text_(session, follower, taps_, experiment_.has_value()) {
  const Plan& plan = session.plan();
  if (plan.graph.duration != until_stopped) extras_.duration = plan.graph.duration.seconds();
  extras_.mouse = node_index(plan, options_.mouse);
  extras_.start = options_.start;
  extras_.drawn = options_.drawn;
  if (const auto methods = method_switch(plan)) method_parameter_ = methods->parameter;
  if (extras_.mouse) mouse_.emplace(session, plan.nodes[*extras_.mouse], options_.start);
  server_ = load_view_library().serve(*this, options_.ports);
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
  HelloExtras extras;
  {
    const std::scoped_lock lock(mutex_);
    extras = extras_;
  }
  return hello_text(session_.plan(), taps_.streams(), extras);
}

std::string SessionView::status() {
  const std::scoped_lock lock(mutex_);
  return status_;
}

void SessionView::receive(ClientId client, const ClientMessage& message) {
  const std::scoped_lock lock(mutex_);
  switch (message.kind) {
    case ClientMessage::Kind::input:
      if (taking_ && mouse_) mouse_->input(message.X_WC, message.held);
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
  if (taking_ && mouse_) mouse_->page_gone();
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
      extras_.values[request.parameter] = request.value;
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
  const Instant now = MonotonicClock::now();
  if (!status_text_.is_due(now)) return;
  std::optional<Hold> hold;
  {
    const std::scoped_lock lock(mutex_);
    if (mouse_) hold = mouse_->hold(now);
  }
  std::string text = status_text_.next(now, hold);
  const std::scoped_lock lock(mutex_);
  status_ = std::move(text);
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
