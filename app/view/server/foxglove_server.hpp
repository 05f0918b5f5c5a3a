// Gives what a view shows to Foxglove, Lichtblick and PlotJuggler, which look and change nothing.
// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "app/view/view_server.hpp"

namespace boost::asio {
class io_context;
}

namespace tactor {

/// Serves on the thread of `io`, whose owner calls `add` and `tell`.
class FoxgloveServer {
 public:
  virtual ~FoxgloveServer() = default;
  /// What a viewer connects to: `ws://127.0.0.1:8765`.
  [[nodiscard]] virtual std::string url() const = 0;
  /// Begins to let viewers in.
  virtual void start() = 0;
  /// A chunk of samples.
  virtual void add(std::string_view chunk) = 0;
  /// A text for pages: viewers learn which parameter has changed, and that the run has ended.
  virtual void tell(const std::string& text) = 0;
  /// Lets nobody in any more.
  virtual void close() = 0;
  /// Whether something waits for a viewer.
  [[nodiscard]] virtual bool is_sending() const = 0;
  /// Ends the connections.
  virtual void stop() = 0;
  [[nodiscard]] virtual bool has_viewers() const = 0;
};

/// Listens on that port of 127.0.0.1. Both outlive the server. Throws InputError where the port is taken or refused.
std::unique_ptr<FoxgloveServer> make_foxglove_server(boost::asio::io_context& io, ViewSource& source,
                                                     std::uint16_t port);

}  // namespace tactor
