// A session as a page sees it: its samples and its state go out, what the page asks for comes in.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/view/hello.hpp"
#include "app/view/hold.hpp"
#include "app/view/led_mouse.hpp"
#include "app/view/status_text.hpp"
#include "app/view/stream_taps.hpp"
#include "app/view/view_server.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/session/follower.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// Serves a session from its making to its end, on a thread of low priority. All but the ViewSource is for the
/// session's thread.
class SessionView final : private ViewSource {
 public:
  struct Options {
    ViewPorts ports;
    std::shared_ptr<const DrawnScene> drawn;  ///< of the session's graph; never null
    std::vector<std::string> meshes;          ///< see mesh_messages
    std::optional<std::string> mouse;         ///< the node device.mouse that the page leads
    Pose start;                               ///< of the handle
  };
  /// Before the session starts; it and the follower outlive the view. `follower`: null where nothing follows; not
  /// started yet. Throws InputError where a port is taken or the build has no view.
  SessionView(Session& session, Follower* follower, Options options);
  /// Ends the server.
  ~SessionView() override;
  SessionView(const SessionView&) = delete;
  SessionView& operator=(const SessionView&) = delete;

  /// What the page is opened by.
  [[nodiscard]] std::string url() const { return server_->url(); }
  /// What a Foxglove viewer connects to; empty where none may.
  [[nodiscard]] std::string foxglove_url() const { return server_->foxglove_url(); }
  /// Does what pages have asked for, and tells them the state; about fifty times a second while the session runs.
  void attend();
  /// Tells the pages that the run has ended, and why, as words for a person; the server goes on until the end of the
  /// object.
  void tell_end(RunEnd end, const std::string& why);
  /// Why a run that is over ended. `failed`: an exception ended it.
  [[nodiscard]] RunEnd end_of_run(bool failed, bool interrupted);
  /// Whether a page has asked to end the run.
  [[nodiscard]] bool was_stopped();
  /// Pages that are open.
  [[nodiscard]] std::uint32_t clients() const { return server_->clients(); }
  /// Why the server ended before its time, where it did.
  [[nodiscard]] std::optional<std::string> failure();

 private:
  struct Request {
    ClientId client = 0;
    std::string parameter, value;
  };

  // ViewSource, on the server's thread.
  std::string hello() override;
  const std::vector<std::string>& first_messages() override { return options_.meshes; }
  const std::vector<std::string>* replay() override { return nullptr; }
  std::string collect() override { return taps_.collect(); }
  std::string status() override;
  void receive(ClientId client, const ClientMessage& message) override;
  void release() override;
  void note(const std::string& text) override;

  void set(const Request& request);

  Session& session_;
  Follower* follower_;
  Options options_;
  const std::optional<std::string> experiment_;  // see experiment_of
  StreamTaps taps_;
  StatusText status_text_;
  std::optional<std::string> method_parameter_;
  std::unique_ptr<ViewServer> server_;

  std::mutex mutex_;  // over what follows
  std::vector<Request> requests_;
  HelloExtras extras_;
  std::string status_;
  std::optional<LedMouse> mouse_;  // where a page leads the device
  bool taking_ = false;            // between the start of the session and its end
  bool stop_asked_ = false;
  std::optional<std::string> failure_;

  std::thread thread_;
};

}  // namespace tactor
