// Shows a run of `tactor run` to pages while it goes on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "app/run/run.hpp"
#include "app/view/session_view.hpp"

namespace tactor {

class RunView final : public RunWatcher {
 public:
  /// `opened` is called with the address of the page. Throws InputError where a mesh cannot be read.
  RunView(const Plan& plan, std::uint16_t port, std::function<void(const std::string& url)> opened);

  void begin(Session& session, Follower* follower) override;
  void attend() override { view_->attend(); }
  void end() override;

 private:
  std::function<void(const std::string& url)> opened_;
  SessionView::Options options_;
  std::unique_ptr<SessionView> view_;
};

}  // namespace tactor
