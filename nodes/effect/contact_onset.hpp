// When a force begins: the contact that an effect answers to.
#pragma once

#include "framework/core/time.hpp"

namespace tactor {

/// Contact begins when the force's norm comes above `threshold` (N) after it has been below it for `quiet`. So a force
/// that flutters about the threshold, and a handle that the effect itself pushes out of the surface, begin nothing.
class ContactOnset {
 public:
  ContactOnset(double threshold, Duration quiet) : threshold_(threshold), quiet_(quiet) {}

  /// True where a contact begins now; times do not fall.
  bool begins(Time now, double force) {
    const bool touches = force > threshold_;
    const bool begin = touches && !touched_ && (!any_ || now - left_ >= quiet_);
    if (touches) {
      left_ = now;
      any_ = true;
    }
    touched_ = touches;
    return begin;
  }

 private:
  double threshold_;
  Duration quiet_;
  Time left_;  // when it last touched
  bool any_ = false, touched_ = false;
};

}  // namespace tactor
