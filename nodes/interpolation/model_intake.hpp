// Which of the models that come to a rollout is in use, and why others are refused.
#pragma once

#include <cstdint>

#include "framework/core/refusals.hpp"
#include "nodes/physics/mechanics/local_model.hpp"

namespace tactor {

/// Keeps the stamp of the model in use. Counts each model once, as used or refused.
class ModelIntake {
 public:
  /// The model in use has come again. Before a force was displayed, none is in use.
  [[nodiscard]] bool is_in_use(const Stamp& stamp) const { return running_ && stamp.sequence == used_.sequence; }
  /// The model is of an older result than the one in use, or of a sample that is later than `now`. The bodies may be
  /// brought on to a sample that has not arrived here yet.
  template <class Model>
  [[nodiscard]] bool is_late(const Stamped<Model>& model, Time now) const {
    return (running_ && model.stamp.valid < used_.valid) || model.value.time > now;
  }
  [[nodiscard]] bool was_refused(const Stamp& stamp) const { return stamp.sequence == refused_sequence_; }

  /// `why`: the reason of LocalRollout, or none, or late.
  void refuse(const Stamped<LocalModel>& model, RefusalReason why) {
    if (why == RefusalReason::too_many) {
      refused_sequence_ = model.stamp.sequence;
      refused_.count_too_many(model.value.contacts.count, LocalContacts::capacity);
    } else {
      // What the rollout would accept by itself does not go with the patch that it steps.
      refuse(model.stamp, why == RefusalReason::none ? RefusalReason::another_scene : why);
    }
  }
  /// A model that counts nothing.
  void refuse(const Stamp& stamp, RefusalReason why) {
    refused_sequence_ = stamp.sequence;
    refused_.count(why);
  }
  /// Returns the interval since the result in use. Of the first one it is the age, which physics took to make it.
  Duration use(const Stamp& stamp, Time now) {
    refused_.count(RefusalReason::none);
    const Duration interval = running_ ? stamp.valid - used_.valid : now - stamp.valid;
    used_ = stamp;
    return interval;
  }
  /// A force of the model in use was displayed.
  void start() { running_ = true; }

  [[nodiscard]] bool running() const { return running_; }
  /// Time of the physics result behind the model in use.
  [[nodiscard]] Time valid() const { return used_.valid; }
  [[nodiscard]] const Refusals& refusals() const { return refused_; }

 private:
  Stamp used_;
  bool running_ = false;
  std::uint64_t refused_sequence_ = ~std::uint64_t{0};  // of the model refused last
  Refusals refused_{"models", "contacts"};
};

}  // namespace tactor
