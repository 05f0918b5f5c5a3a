#include "app/view/run_view.hpp"

#include <utility>

#include "app/view/hello.hpp"

namespace tactor {

RunView::RunView(const Plan& plan, const ViewPorts& ports, Opened opened, std::function<bool()> interrupted)
    : opened_(std::move(opened)), interrupted_(std::move(interrupted)) {
  options_.ports = ports;
  // What is to be known of the meshes the run's own nodes say.
  options_.drawn = std::make_shared<const DrawnScene>(drawn_scene(plan.graph));
  options_.meshes = mesh_messages(*options_.drawn, [](const std::string&) {});
  if (const Body* tool = plan.graph.scene.tool(); tool != nullptr) options_.start = tool->X_WB;
}

void RunView::begin(Session& session, Follower* follower) {
  view_ = std::make_unique<SessionView>(session, follower, options_);
  opened_(view_->url(), view_->foxglove_url());
}

void RunView::end(bool failed) {
  const RunEnd end = view_->end_of_run(failed, interrupted_());
  view_->tell_end(end, end == RunEnd::failed || end == RunEnd::stalled ? "the run has failed" : "the run is over");
  view_.reset();
}

}  // namespace tactor
