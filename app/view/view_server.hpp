// The view's server without what it is made of: what it shows, how it is served, and the library that does it.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// A page that is connected; counted from 1.
using ClientId = std::uint32_t;

/// What a page asks for. docs/reference/view_protocol.md
struct ClientMessage {
  enum class Kind : std::uint8_t { ack, input, set, stop, control };
  Kind kind = Kind::ack;
  std::uint64_t frame = 0;       ///< of ack
  Pose X_WC;                     ///< of input: m, with a unit quaternion
  bool held = false;             ///< of input
  std::string parameter, value;  ///< of set
};

/// What is shown. The server calls it on one thread, but for `note`. docs/reference/view_protocol.md tells the texts
/// and bytes.
class ViewSource {
 public:
  virtual ~ViewSource() = default;
  /// The text `hello`, a JSON object, without `client`.
  virtual std::string hello() = 0;
  /// Binary messages that follow `hello`.
  virtual const std::vector<std::string>& first_messages() = 0;
  /// All frames of a replay, numbered from 1; null where the run goes on.
  virtual const std::vector<std::string>* replay() = 0;
  /// The chunk of samples since the last call; empty where there are none. About 40 times a second, unless a replay.
  virtual std::string collect() = 0;
  /// The text `status`, without what the server knows; empty: there is none. Four times a second.
  virtual std::string status() = 0;
  /// What the page in control asks for, and `stop` from any page; never `ack` and `control`.
  virtual void receive(ClientId client, const ClientMessage& message) = 0;
  /// The page in control has gone.
  virtual void release() = 0;
  /// Something that the user is to know and that nothing stops for. Any thread.
  virtual void note(const std::string& text) = 0;
};

/// A file that the server has to give.
struct ViewFile {
  const char* path = nullptr;          ///< `/view.js`
  const char* content_type = nullptr;  ///< with its character set
  std::string_view gzip;               ///< its bytes, compressed
};

/// Where a view is served, on 127.0.0.1.
struct ViewPorts {
  std::uint16_t page = 0;                 ///< 0: any that is free
  std::optional<std::uint16_t> foxglove;  ///< of the server for Foxglove, where there is to be one
  /// Origins of pages that may read the stream for Foxglove: `https://app.foxglove.dev`.
  std::vector<std::string> allowed_origins;
};

/// Serves one view.
class ViewServer {
 public:
  virtual ~ViewServer() = default;
  /// What the page is opened by: `http://127.0.0.1:8080/#TOKEN`.
  [[nodiscard]] virtual std::string url() const = 0;
  /// What a Foxglove viewer connects to; empty where none may.
  [[nodiscard]] virtual std::string foxglove_url() const = 0;
  /// Serves until `stop`, on the calling thread.
  virtual void run() = 0;
  /// Any thread: a text for one client or, without one, for all.
  virtual void post(std::string text, std::optional<ClientId> client = {}) = 0;
  /// Any thread: sends what waits, for at most a second, and ends `run`.
  virtual void stop() = 0;
  /// Pages that are connected; viewers of Foxglove do not count. Any thread.
  [[nodiscard]] virtual std::uint32_t clients() const = 0;
};

/// The functions of the library of the view.
struct ViewLibrary {
  /// `source` outlives the server. Throws InputError where a port is taken or refused.
  std::unique_ptr<ViewServer> (*serve)(ViewSource& source, const ViewPorts& ports);
  /// Writes a replay as MCAP: `hello`, first messages and frames as ViewSource gives them. A write that fails is seen
  /// at the stream.
  void (*export_mcap)(std::ostream& out, const std::string& hello, const std::vector<std::string>& first_messages,
                      const std::vector<std::string>& frames);
  /// The program of the page. `/saved.html` is a page that replays the recording it is given.
  std::span<const ViewFile> (*files)();
};

/// Loads libtactor_view.so, once. Throws InputError where it is not there: then the build has no view.
const ViewLibrary& load_view_library();

}  // namespace tactor

/// The one symbol that libtactor_view.so exports; null where the caller is of another build.
extern "C" const tactor::ViewLibrary* tactor_view_library();
