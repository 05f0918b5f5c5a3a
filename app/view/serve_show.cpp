#include "app/view/serve_show.hpp"

#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "app/output.hpp"
#include "app/view/view_server.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace {

class ShowSource final : public ViewSource {
 public:
  explicit ShowSource(Show show) : show_(std::move(show)) {}
  std::string hello() override { return show_.hello; }
  const std::vector<std::string>& first_messages() override { return show_.meshes; }
  const std::vector<std::string>* replay() override { return &show_.frames; }
  std::string collect() override { return {}; }
  std::string status() override { return {}; }
  // Each page plays the show by a clock of its own.
  void receive(ClientId, const ClientMessage&) override {}
  void release() override {}
  void note(const std::string& text) override { tell_note(text); }

 private:
  Show show_;
};

}  // namespace

void serve_show(Show show, std::uint16_t port, const std::function<void(const std::string& url)>& opened,
                const std::function<bool()>& stop_asked) {
  constexpr std::chrono::milliseconds look_period{100};
  ShowSource source(std::move(show));
  const std::unique_ptr<ViewServer> server = load_view_library().serve(source, {port, {}, {}});
  std::thread thread = make_thread("view", [&server] { server->run(); });
  opened(server->url());
  while (!stop_asked()) std::this_thread::sleep_for(look_period);
  server->stop();
  thread.join();
}

}  // namespace tactor
