// Shows a run of `tactor run` to pages while it goes on.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/run/run.hpp"
#include "app/view/session_view.hpp"

namespace tactor {

class RunView final : public RunWatcher {
 public:
  using Opened = std::function<void(const std::string& url, const std::string& foxglove)>;
  /// `opened`: see ViewOptions. `interrupted`: whether a signal ends the run. Throws InputError where a mesh cannot be
  /// read.
  RunView(const Plan& plan, const ViewPorts& ports, Opened opened, std::function<bool()> interrupted);

  void begin(Session& session, Follower* follower) override;
  void attend() override { view_->attend(); }
  void end(bool failed) override;

 private:
  Opened opened_;
  std::function<bool()> interrupted_;
  SessionView::Options options_;
  std::unique_ptr<SessionView> view_;
};

}  // namespace tactor
