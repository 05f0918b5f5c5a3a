#include "app/bridge/bridge_run.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/bridge/bridge_json.hpp"
#include "app/bridge/bridge_packed.hpp"
#include "app/bridge/bridge_result.hpp"

namespace tactor {

namespace {

using HelloJson = nlohmann::ordered_json;

constexpr Duration patience{20'000'000};

HelloJson numbers(const Vec3& v) {
  return {v.x, v.y, v.z};
}

template <class Message>
BridgeFrame frame_of(const Message& message, bool packed) {
  return {packed ? to_bytes(message) : to_text(message), packed};
}

HelloJson body_json(const Body& body) {
  HelloJson object{
      {"name", body.name}, {"mass", body.mass}, {"motion", body.motion == Motion::rigid ? "rigid" : "translation"}};
  if (body.inertia) object["inertia"] = numbers(*body.inertia);
  object["p_WB"] = numbers(body.X_WB.p);
  const Quat& q = body.X_WB.R;
  object["R_WB"] = {q.w, q.x, q.y, q.z};
  return object;
}

}  // namespace

BridgeRun::BridgeRun(BridgeServer& server, Session& session, BridgeFigures& figures)
    : server_(server),
      session_(session),
      figures_(figures),
      loop_(session),
      is_virtual_(session.plan().graph.clock == Clock::virtual_) {}

void BridgeRun::attend() {
  const Instant until = MonotonicClock::now() + patience;
  while (loop_.is_running()) {
    const Duration left = until - MonotonicClock::now();
    if (left <= Duration{}) return;
    if (server_.client() != client_) meet(server_.client());
    if (client_ == 0 || open_) {
      server_.serve(left);
    } else if (open_step(left)) {
      send_open();
    } else {
      server_.serve({});
    }
    if (const auto arrival = server_.take()) take(*arrival);
  }
}

void BridgeRun::meet(BridgeClient client) {
  client_ = client;
  packed_ = greeted_ = false;
  fresh_ = true;
  if (!is_virtual_) open_.reset();
  if (client_ == 0) return;
  ++figures_.clients;
  if (open_) send_open();
}

bool BridgeRun::open_step(Duration longest) {
  std::optional<PhysicsStep> step = loop_.next_within(longest);
  // Live, the first step after a pause is as long as that; the one after it is a client's first.
  if (step && !is_virtual_ && std::exchange(fresh_, false)) step = loop_.next_within(longest);
  if (!step) return false;
  open_ = Open{++figures_.steps, *step};
  return true;
}

void BridgeRun::send_open() {
  if (!std::exchange(greeted_, true)) server_.send({hello(), false});
  const PhysicsStep& step = open_->step;
  server_.send(frame_of(BridgeStep{open_->id, step.begin, step.end, step.from, step.handle, step.coupling}, packed_),
               true);
}

void BridgeRun::take(const BridgeArrival& arrival) {
  packed_ = arrival.frame.packed;
  try {
    if (arrival.too_large) {
      throw BridgeRefusal("", "expected a frame of at most " + std::to_string(BridgeServer::frame_limit) + " bytes");
    }
    const std::string_view bytes = arrival.frame.bytes;
    const auto message = packed_ ? read_client_bytes(bytes) : read_client_message(bytes);
    if (std::holds_alternative<BridgeNext>(message)) {
      if (!is_virtual_) {
        close_step();
      } else if (open_) {
        send_open();
      }
      return;
    }
    const auto& result = std::get<BridgeResult>(message);
    if (!open_ || result.id != open_->id) {
      // The open step is still to be answered.
      const std::string open = open_ ? "step " + std::to_string(open_->id) : "no step";
      return refuse({"expected the open step, found " + std::to_string(result.id) + "; open is " + open, "id"});
    }
    loop_.result(open_->step, physics_result(result, *contacts_, bodies_));
    ++figures_.results;
    figures_.latency.record(MonotonicClock::now() - arrival.at);
  } catch (const BridgeRefusal& refusal) {
    refuse({refusal.what(), refusal.field()});
  } catch (const ResultError& error) {
    refuse({error.reason(), error.field()});
  }
  close_step();
}

void BridgeRun::close_step() {
  open_.reset();
  server_.settle();
}

void BridgeRun::refuse(const BridgeError& error) {
  ++figures_.refused;
  server_.send(frame_of(error, packed_));
}

std::string BridgeRun::hello() const {
  const Plan& plan = session_.plan();
  const Scene& scene = plan.graph.scene;
  const NodeSpec& node = loop_.node();
  HelloJson bodies = HelloJson::array();
  for (const std::size_t index : scene.moving()) bodies.push_back(body_json(scene.bodies[index]));
  HelloJson hello{{"type", "hello"},
                  {"protocol", bridge_protocol},
                  {"version", TACTOR_VERSION},
                  {"graph", plan.graph.name},
                  {"clock", is_virtual_ ? "virtual" : "real"},
                  {"rate", std::get<double>(node.params[node.info->param("rate").value()])},
                  {"gravity", numbers(scene.gravity_W)},
                  {"tool", scene.tool() != nullptr ? HelloJson(scene.tool()->name) : HelloJson()},
                  {"bodies", std::move(bodies)},
                  {"coupling", loop_.has_coupling() ? HelloJson::parse(to_text(open_->step.coupling)) : HelloJson()}};
  hello["limits"] = {{"frame", BridgeServer::frame_limit}, {"contacts", ContactSet::capacity}};
  hello["layouts"] = HelloJson::parse(packed_layouts());
  return hello.dump(-1, ' ', false, HelloJson::error_handler_t::replace);
}

std::string bridge_text(const BridgeFigures& figures) {
  std::string text = fmt::format("bridge: {} steps sent, {} results taken, {} refused, {} clients", figures.steps,
                                 figures.results, figures.refused, figures.clients);
  if (figures.latency.count() == 0) return text;
  return text + fmt::format("; from result to run 50 % {:.0f} us, 99 % {:.0f} us, most {:.0f} us",
                            figures.latency.quantile(0.5).microseconds(), figures.latency.quantile(0.99).microseconds(),
                            figures.latency.max().microseconds());
}

std::string bridge_json(const BridgeFigures& figures) {
  HelloJson object{{"steps", figures.steps},
                   {"results", figures.results},
                   {"refused", figures.refused},
                   {"clients", figures.clients}};
  HelloJson& latency = object["latency_us"] = HelloJson::object();
  if (figures.latency.count() > 0) {
    for (const auto& [name, q] : {std::pair{"p50", 0.5}, {"p99", 0.99}, {"p99_9", 0.999}}) {
      latency[name] = figures.latency.quantile(q).microseconds();
    }
    latency["max"] = figures.latency.max().microseconds();
  }
  return object.dump(2) + "\n";
}

}  // namespace tactor
