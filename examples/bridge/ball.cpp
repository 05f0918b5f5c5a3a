// A ball above a plane as the physics of `tactor bridge graph.yaml`; messages are packed bytes. Needs Boost.Beast.
#include <algorithm>
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

namespace {

constexpr double radius = 0.004, mass = 0.05;        // m, kg
constexpr double stiffness = 2000.0, damping = 2.0;  // N/m, N s/m, of the plane
constexpr double substep = 2.5e-4;                   // s

// The packed messages, as docs/howto/bridge.md has them.
using Vec3 = std::array<double, 3>;
struct Handle {
  Vec3 p;
  std::array<double, 4> R;
  Vec3 v, w;
  std::int64_t buttons;
};
struct Step {
  std::uint32_t kind, given;
  std::uint64_t id;
  std::int64_t begin, end;  // ns
  Handle from, handle;
  double k_t, b_t, k_r, b_r, force_max, torque_max;
  std::int64_t massless;
};
struct Result {
  std::uint32_t kind = 2, given = 1U << 1U | 1U << 3U;  // tool and contact
  std::uint64_t id = 0;
  std::int64_t time = 0;
  Vec3 p{};
  std::array<double, 4> R{1, 0, 0, 0};
  Vec3 v{}, w{};
  Vec3 felt_force{}, felt_torque{}, contact_force{}, contact_torque{};
  std::uint64_t contacts = 0, bodies = 0;
};
static_assert(sizeof(Step) == 312 && sizeof(Result) == 240);

/// Implicit Euler: m (v' - v) / dt = k (x_D - x - dt v') + b (v_D - v') + the force of the plane.
class Ball {
 public:
  Result step(const Step& step) {
    if (!placed_) p_ = step.from.p;
    placed_ = true;
    const double span = static_cast<double>(step.end - step.begin) * 1e-9;
    const double count = std::max(1.0, std::ceil(span / substep)), dt = span / count;
    double push = 0;
    for (int i = 1; i <= static_cast<int>(count); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double way = step.handle.p[axis] - step.from.p[axis];
        const double pull = step.k_t * (step.from.p[axis] + way * i / count - p_[axis]) + step.b_t * way / span;
        const double momentum = mass * v_[axis] + dt * pull, resistance = mass + dt * step.b_t + dt * dt * step.k_t;
        v_[axis] = momentum / resistance;
        if (axis == 2) push = push_up(momentum, resistance, dt);
        p_[axis] += dt * v_[axis];
      }
    }
    Result result;
    result.id = step.id;
    result.p = p_;
    result.v = v_;
    result.contact_force[2] = push;
    return result;
  }

 private:
  /// The force of the plane, which only pushes, and with it the speed along z at the end of a sub-step.
  double push_up(double momentum, double resistance, double dt) {
    const double depth = radius - p_[2];
    const double speed = (momentum + dt * stiffness * depth) / (resistance + dt * damping + dt * dt * stiffness);
    const double push = stiffness * (depth - dt * speed) - damping * speed;
    if (depth <= 0 || push <= 0) return 0;
    v_[2] = speed;
    return push;
  }

  Vec3 p_{}, v_{};
  bool placed_ = false;
};

/// Answers steps until the run is over.
void serve(const std::string& url) {
  namespace beast = boost::beast;
  namespace websocket = beast::websocket;
  using boost::asio::ip::tcp;
  const std::size_t begin = url.find("//") + 2, colon = url.find(':', begin), path = url.find('/', begin),
                    token = url.find('#');
  if (std::max({colon, path, token}) == std::string::npos)
    throw std::invalid_argument("expected ws://HOST:PORT/bridge#TOKEN");
  const std::string host = url.substr(begin, path - begin);
  boost::asio::io_context io;
  websocket::stream<tcp::socket> bridge(io);
  boost::asio::connect(bridge.next_layer(), tcp::resolver(io).resolve(url.substr(begin, colon - begin),
                                                                      url.substr(colon + 1, path - colon - 1)));
  bridge.next_layer().set_option(tcp::no_delay(true));
  bridge.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
    request.set(beast::http::field::sec_websocket_protocol, "tactor.bridge, token." + url.substr(token + 1));
  }));
  bridge.handshake(host, url.substr(path, token - path));
  bridge.binary(true);
  const std::uint32_t next = 4;  // from now on steps are packed
  bridge.write(boost::asio::buffer(&next, sizeof next));
  Ball ball;
  for (beast::flat_buffer buffer;; buffer.clear()) {
    beast::error_code error;
    bridge.read(buffer, error);
    if (error == websocket::error::closed) return;
    if (error) throw beast::system_error(error);
    const std::string message = beast::buffers_to_string(buffer.data());
    if (bridge.got_text()) continue;   // the greeting, and a step that came before our request
    std::uint32_t kind = 0, size = 0;  // an error has the size of its text next
    if (message.size() < sizeof kind + sizeof size) throw std::runtime_error("the bridge sent no message");
    std::memcpy(&kind, message.data(), sizeof kind);
    if (kind == 3) {
      std::memcpy(&size, message.data() + sizeof kind, sizeof size);
      std::fprintf(stderr, "the bridge refused a result: %s\n", message.substr(12, size).c_str());
      continue;
    }
    Step step;
    if (kind != 1 || message.size() != sizeof step) throw std::runtime_error("the bridge sent no step");
    std::memcpy(&step, message.data(), sizeof step);
    const Result result = ball.step(step);
    bridge.write(boost::asio::buffer(&result, sizeof result));
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::invalid_argument("expected the address that tactor bridge prints");
  serve(argv[1]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
