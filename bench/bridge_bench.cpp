// From a result of foreign physics to the force segment that the run makes of it: with the program in the process, and
// in a client of the bridge over a socket of this machine. Beside it a plain echo of a frame of the same size over the
// same library, there and back.
//
// bridge_bench [--seconds S] [--rate HZ]: prints JSON; three rows, each of S seconds.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/bridge/bridge_packed.hpp"
#include "app/bridge/bridge_run.hpp"
#include "app/bridge/bridge_server.hpp"
#include "framework/core/check.hpp"
#include "framework/graph/patch.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/session/physics_loop.hpp"

using namespace tactor;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using Socket = websocket::stream<tcp::socket>;

namespace {

struct Options {
  double seconds = 20;
  double rate = 500;  // Hz, of physics
};

/// When results were given, by the times that they hold for; any thread.
class Given {
 public:
  void add(Time valid) {
    const Instant now = MonotonicClock::now();
    const std::scoped_lock lock(mutex_);
    given_.emplace_back(valid, now);
  }
  /// Counts how long the segments took that the tap has got.
  void meet(Session& session, Session::OutputTap& segments, LatencyHistogram& latency) {
    const Instant origin = MonotonicClock::now() - (session.now() - Time{});
    const std::scoped_lock lock(mutex_);
    while (const MessageView segment = segments.take()) {
      const auto given = std::find_if(given_.begin(), given_.end(),
                                      [&segment](const auto& one) { return one.first == segment.stamp->valid; });
      if (given == given_.end()) continue;
      latency.record(origin + (segment.stamp->produced - Time{}) - given->second);
      given_.erase(given_.begin(), given + 1);
    }
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<Time, Instant>> given_;
};

/// The tool stays where the handle is: all time goes into the way.
Plan plan_of(const Options& options, Registry& registry) {
  const auto set = [](const std::string& path, const std::string& value) {
    return option_patch("bridge_bench", path, value);
  };
  return make_plan(load_graph(TACTOR_SOURCE_DIR "/examples/bridge/graph.yaml", registry,
                              {set("physics.rate", fmt::format("{} Hz", options.rate)),
                               set("duration", fmt::format("{} s", options.seconds))}));
}

void run_in_process(const Options& options, Registry& registry, LatencyHistogram& latency) {
  Session session(plan_of(options, registry));
  const auto segments = session.tap("interpolation.segment", {QueuePolicy::drop_oldest, 4096});
  Given given;
  PhysicsLoop loop(session);
  while (const auto step = loop.next()) {
    PhysicsResult result;
    result.X_WT = step->handle.X_WD;
    result.V_WT = step->handle.V_WD;
    given.add(step->end);
    loop.result(*step, result);
    given.meet(session, *segments, latency);
  }
  session.finish();
}

/// A connection to a server of this machine.
std::unique_ptr<Socket> connected(boost::asio::io_context& io, const std::string& port, const std::string& path,
                                  const std::string& protocols) {
  auto socket = std::make_unique<Socket>(io);
  boost::asio::connect(socket->next_layer(), tcp::resolver(io).resolve("127.0.0.1", port));
  socket->next_layer().set_option(tcp::no_delay(true));
  socket->set_option(websocket::stream_base::decorator([protocols](websocket::request_type& request) {
    request.set(beast::http::field::sec_websocket_protocol, protocols);
  }));
  socket->handshake("127.0.0.1:" + port, path);
  socket->binary(true);
  return socket;
}

/// Reads until the connection is closed.
void read_all(Socket& socket, const std::function<void(const std::string&)>& take) {
  beast::error_code error;
  for (beast::flat_buffer buffer; !error; buffer.clear()) {
    socket.read(buffer, error);
    if (!error && socket.got_binary()) take(beast::buffers_to_string(buffer.data()));
  }
}

void answer_steps(const std::string& url, Given& given) {
  const std::size_t colon = url.rfind(':'), path = url.find('/', colon), token = url.find('#');
  boost::asio::io_context io;
  const auto socket = connected(io, url.substr(colon + 1, path - colon - 1), url.substr(path, token - path),
                                "tactor.bridge, token." + url.substr(token + 1));
  const auto next = static_cast<std::uint32_t>(BridgeKind::next);
  socket->write(boost::asio::buffer(&next, sizeof next));
  read_all(*socket, [&](const std::string& message) {
    const BridgeStep step = read_step_bytes(message);
    BridgeResult result;
    result.id = step.id;
    result.tool = BridgeTool{step.handle.X_WD, step.handle.V_WD, true};
    const std::string answer = to_bytes(result);
    given.add(step.end);
    beast::error_code ignored;  // the run may be over
    socket->write(boost::asio::buffer(answer), ignored);
  });
}

void run_by_socket(const Options& options, Registry& registry, LatencyHistogram& latency, BridgeFigures& figures) {
  Session session(plan_of(options, registry));
  const auto segments = session.tap("interpolation.segment", {QueuePolicy::drop_oldest, 4096});
  BridgeServer server({}, [](const std::string& note) { fmt::print(stderr, "{}\n", note); });
  BridgeRun run(server, session, figures);
  Given given;
  std::thread client([&] { answer_steps(server.url(), given); });
  session.run({}, [&] {
    run.attend();
    given.meet(session, *segments, latency);
  });
  server.close("the run is over");
  client.join();
}

/// Frames of the size of a result go there and back, at the same rate.
void run_echo(const Options& options, LatencyHistogram& latency) {
  boost::asio::io_context io;
  tcp::acceptor acceptor(io, {boost::asio::ip::address_v4::loopback(), 0});
  std::thread server([&] {
    Socket socket(acceptor.accept());
    socket.next_layer().set_option(tcp::no_delay(true));
    socket.accept();
    socket.binary(true);
    read_all(socket, [&](const std::string& message) { socket.write(boost::asio::buffer(message)); });
  });
  boost::asio::io_context own;
  const auto socket = connected(own, std::to_string(acceptor.local_endpoint().port()), "/", "echo");
  const std::string frame = to_bytes(BridgeResult{});
  Instant next = MonotonicClock::now();
  const Instant end = next + Duration::from_seconds(options.seconds);
  for (beast::flat_buffer buffer; next < end; buffer.clear()) {
    next = next + Duration::from_rate(options.rate);
    MonotonicClock::sleep_until(next);
    const Instant sent = MonotonicClock::now();
    socket->write(boost::asio::buffer(frame));
    socket->read(buffer);
    latency.record(MonotonicClock::now() - sent);
  }
  socket->close(websocket::close_code::normal);
  server.join();
}

nlohmann::ordered_json row(const char* name, const LatencyHistogram& latency) {
  return {{"row", name},
          {"count", latency.count()},
          {"p50_us", latency.quantile(0.5).microseconds()},
          {"p99_us", latency.quantile(0.99).microseconds()},
          {"max_us", latency.max().microseconds()}};
}

/// False where the words are no options.
bool read_options(int count, char** words, Options& options) {
  for (int i = 1; i < count; i += 2) {
    const std::string word = words[i];
    if (i + 1 == count || (word != "--seconds" && word != "--rate")) return false;
    (word == "--rate" ? options.rate : options.seconds) = std::atof(words[i + 1]);
  }
  return options.seconds >= 1 && options.rate >= 1 && options.rate <= 10'000;
}

}  // namespace

int main(int count, char** words) try {
  Options options;
  if (!read_options(count, words, options)) {
    fmt::print(stderr, "usage: bridge_bench [--seconds S] [--rate HZ], at least 1 s, 1 to 10000 Hz\n");
    return 2;
  }
  Registry registry(default_node_folders());
  LatencyHistogram in_process, by_socket, echo;
  run_in_process(options, registry, in_process);
  BridgeFigures figures;
  run_by_socket(options, registry, by_socket, figures);
  run_echo(options, echo);
  nlohmann::ordered_json rows{row("in process", in_process), row("by socket", by_socket),
                              row("by socket, from the end of reading to the run", figures.latency),
                              row("echo, there and back", echo)};
  fmt::print("{}\n", rows.dump(1));
} catch (const std::exception& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 1;
}
