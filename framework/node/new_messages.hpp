// Reads every new message at an input, for any queue policy of its edge.
#pragma once

#include "framework/node/port.hpp"

namespace tactor {

/// Gives the messages of one input, each once and in order. On a `latest` edge, it gives the newest if it is new.
template <class T>
class NewMessages {
 public:
  /// Copies the next new message of `in` to `out`; false where there is none.
  bool next(Input<T>& in, Stamped<T>& out) {
    if (in.pop(out)) return remember(out.stamp);
    // An engine has marked a `latest` message as seen by now, so that it can no longer be popped.
    const Stamped<T>* newest = in.latest();
    if (newest == nullptr) return false;
    if (any_ && newest->stamp.valid == last_.valid && newest->stamp.sequence == last_.sequence) return false;
    out = *newest;
    return remember(out.stamp);
  }

 private:
  bool remember(const Stamp& stamp) {
    last_ = stamp;
    any_ = true;
    return true;
  }

  Stamp last_;
  bool any_ = false;
};

}  // namespace tactor
