// Leads the hand into a wall, and prints the force that it gets.
#include <cstdio>

#include "framework/core/messages.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "framework/session/add_feed.hpp"
#include "framework/session/session.hpp"
#include "framework/yaml/file_finder.hpp"

int main() try {
  tactor::Registry registry(tactor::default_node_folders());
  tactor::GraphSpec graph = tactor::load_graph(tactor::named_file("wall/refit", tactor::graph_files), registry);
  tactor::add_feed(graph, "device.target", registry);
  tactor::Session session(tactor::make_plan(graph));
  tactor::Session::Feed hand = session.feed("device.target");
  const auto force = session.tap("device.commanded");
  session.start();
  for (int ms = 0; ms <= 1000; ++ms) {
    tactor::Target target;
    target.X_WH.p.z = 0.010 - 0.010 * ms / 1000;  // m, of the ball's middle; it touches at 4 mm
    target.V_WH.v.z = -0.010;                     // m/s
    if (!hand.send(target)) return 1;
    session.advance(tactor::Duration{1'000'000});
    tactor::Wrench F_D_W;
    while (const auto message = force->take()) F_D_W = *reinterpret_cast<const tactor::Wrench*>(message.value);
    if (ms % 100 == 0) std::printf("%.3f s  %6.2f mm  %.3f N\n", ms * 1e-3, target.X_WH.p.z * 1e3, F_D_W.force.z);
  }
  session.finish();
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
