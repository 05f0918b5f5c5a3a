// Gives what a view shows to Foxglove, Lichtblick and PlotJuggler, which look and change nothing.
// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/view/view_server.hpp"

namespace tactor {

/// Serves on a thread of its own, so that no viewer delays the view. Every function may be called on any thread and
/// does not wait, but for the destructor.
class FoxgloveServer {
 public:
  virtual ~FoxgloveServer() = default;
  /// What a viewer connects to: `ws://127.0.0.1:8765`.
  [[nodiscard]] virtual std::string url() const = 0;
  /// Begins to let viewers in. The thread has the priority of the caller.
  virtual void start() = 0;
  /// A chunk of samples. It is left out where too much waits to be translated.
  virtual void add(std::shared_ptr<const std::string> chunk) = 0;
  /// A text for pages: viewers learn which parameter has changed, and that the run has ended.
  virtual void tell(std::string text) = 0;
  /// Lets nobody in any more.
  virtual void close() = 0;
  /// Whether something waits for a viewer.
  [[nodiscard]] virtual bool is_sending() const = 0;
  [[nodiscard]] virtual bool has_viewers() const = 0;
};

/// Listens on that port of 127.0.0.1. `source` outlives the server, which asks it for `hello` and the first messages
/// here, and later only tells it notes. Throws InputError where the port is taken or refused.
std::unique_ptr<FoxgloveServer> make_foxglove_server(ViewSource& source, std::uint16_t port,
                                                     std::vector<std::string> allowed_origins);

}  // namespace tactor
