// Serves the bridge to one client at a time, over WebSocket.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/bridge/bridge_messages.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

class BridgeHub;

/// The address of a bridge and the token that lets a client in.
struct BridgeAddress {
  std::string listen = "127.0.0.1";  ///< an IPv4 address of this machine; 0.0.0.0: all of them
  std::uint16_t port = 0;            ///< 0: any that is free
  std::string token;                 ///< empty: a random one
};

/// A frame from the client.
struct BridgeArrival {
  BridgeFrame frame;
  bool too_large = false;  ///< the frame was longer than `BridgeServer::frame_limit`, and is left out
  Instant at;              ///< the end of reading it
};

/// A client, which a number identifies; counted from 1.
using BridgeClient = std::uint32_t;

/// Does its work in `serve`, on the thread that calls it. A client that has owed an answer, and sent nothing, for
/// `longest_silence` gives way to the next one; any other keeps its place until it ends the connection.
class BridgeServer {
 public:
  static constexpr std::size_t frame_limit = std::size_t{1} << 20U;  ///< bytes, of a frame from the client
  static constexpr Duration longest_silence{1'000'000'000};

  /// Listens. `note` takes what the user is to know. Throws InputError where address, port or token is refused.
  BridgeServer(const BridgeAddress& address, std::function<void(const std::string&)> note);
  ~BridgeServer();
  BridgeServer(const BridgeServer&) = delete;
  BridgeServer& operator=(const BridgeServer&) = delete;

  /// The address for clients, with the token behind #: `ws://127.0.0.1:41234/bridge#TOKEN`.
  [[nodiscard]] std::string url() const;
  /// Does one piece of work, and waits for it for `longest` at most.
  void serve(Duration longest);
  /// The client that is connected; 0: none.
  [[nodiscard]] BridgeClient client() const;
  /// Sends a frame to the client. Without a client the frame is lost. `asks`: the client owes an answer from then on.
  void send(BridgeFrame frame, bool asks = false);
  /// The client owes no answer any more.
  void settle();
  /// The frame that has come. The next one is read when all that was sent has been written.
  [[nodiscard]] std::optional<BridgeArrival> take();
  /// Lets nobody in any more, ends the connection of the client with `why`, and waits for a moment until it has gone.
  void close(const std::string& why);

 private:
  std::unique_ptr<BridgeHub> hub_;
};

}  // namespace tactor
