// A run whose physics is a client of the bridge: steps go out, results come in.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "app/bridge/bridge_messages.hpp"
#include "app/bridge/bridge_server.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/session/physics_loop.hpp"

namespace tactor {

/// Counts and times of a bridge.
struct BridgeFigures {
  std::uint64_t steps = 0;    ///< sent
  std::uint64_t results = 0;  ///< taken
  std::uint64_t refused = 0;  ///< frames
  std::uint64_t clients = 0;
  LatencyHistogram latency;  ///< from the end of reading a result until the run has it
};

/// Drives the node physics.external of a session for a client. A frame that is refused changes nothing: the client is
/// told, and goes on with the next step.
///
/// Real clock: the client always gets the newest step, and the run goes on whether it answers or not. Virtual clock:
/// the run stands still until the step is answered or refused, so that it has the same bytes however long that takes.
class BridgeRun {
 public:
  /// All outlive it. Throws as PhysicsLoop does.
  BridgeRun(BridgeServer& server, Session& session, BridgeFigures& figures);

  /// Exchanges steps and results for 20 ms of wall time, or until the session has ended.
  void attend();

 private:
  struct Open {
    std::uint64_t id = 0;
    PhysicsStep step;
  };

  void meet(BridgeClient client);
  /// False if no step has begun within `longest`.
  bool open_step(Duration longest);
  void send_open();
  void take(const BridgeArrival& arrival);
  void close_step();
  void refuse(const BridgeError& error);
  [[nodiscard]] std::string hello() const;

  BridgeServer& server_;
  Session& session_;
  BridgeFigures& figures_;
  PhysicsLoop loop_;
  const bool is_virtual_;
  BridgeClient client_ = 0;   // 0: none
  bool packed_ = false;       // how the client wrote last
  bool greeted_ = false;      // the client
  bool fresh_ = false;        // the client computes its first step
  std::optional<Open> open_;  // waits for its result
  std::unique_ptr<ContactSet> contacts_ = std::make_unique<ContactSet>();
  BodyStates bodies_;
};

/// The figures on one line, in words.
std::string bridge_text(const BridgeFigures& figures);
/// The same as JSON.
std::string bridge_json(const BridgeFigures& figures);

}  // namespace tactor
