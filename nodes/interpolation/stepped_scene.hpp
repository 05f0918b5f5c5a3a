// The scene as a node steps it at each sample of the handle.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "nodes/physics/contact/contact_source.hpp"
#include "nodes/physics/contact/soft_contact_source.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

/// A local rollout with the sources of its contacts. It counts its steps and the work of their contact queries.
class SteppedScene {
 public:
  /// `surface` and `soft` as in LocalRollout.
  SteppedScene(std::unique_ptr<ContactSource> surface, std::unique_ptr<SoftContactSource> soft,
               const SystemModel& model)
      : surface_(std::move(surface)), soft_(std::move(soft)), rollout_(model, surface_.get(), soft_.get()) {}

  [[nodiscard]] LocalRollout& rollout() { return rollout_; }
  [[nodiscard]] const LocalRollout& rollout() const { return rollout_; }
  [[nodiscard]] bool deforms() const { return soft_ != nullptr; }

  /// LocalRollout::advance, counted.
  bool advance(const Stamped<DeviceState>& sample) {
    const bool converged = rollout_.advance(sample);
    ++steps_;
    if (!rollout_.on_surface()) ++steps_on_anchors_;
    const int work = surface_ == nullptr ? 0 : surface_->work();
    work_ += work;
    most_work_ = std::max<std::int64_t>(most_work_, work);
    return converged;
  }

  /// Steps on the contacts that came with the model.
  [[nodiscard]] std::int64_t steps_on_anchors() const { return steps_on_anchors_; }
  /// Work of the contact query of a step, mean and most.
  [[nodiscard]] double work_mean() const {
    return steps_ > 0 ? static_cast<double>(work_) / static_cast<double>(steps_) : 0.0;
  }
  [[nodiscard]] std::int64_t work_most() const { return most_work_; }

 private:
  std::unique_ptr<ContactSource> surface_;   // null where the contacts of the model serve
  std::unique_ptr<SoftContactSource> soft_;  // null where nothing deforms
  LocalRollout rollout_;
  std::int64_t steps_ = 0, steps_on_anchors_ = 0;
  std::int64_t work_ = 0, most_work_ = 0;
};

}  // namespace tactor
