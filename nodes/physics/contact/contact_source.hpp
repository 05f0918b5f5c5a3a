// Where a rollout may find the contacts anew at each of its steps.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// The surfaces about the moving bodies, which can be asked where these are now.
class ContactSource {
 public:
  virtual ~ContactSource() = default;
  /// The contacts there. False, and `set` is as it was, where finding them is more work than may be done. It
  /// allocates nothing.
  virtual bool find(const BodyStates& bodies, ContactSet& set) = 0;
  /// Steps of work that the last one took (see SampleTree::find); 0 where nobody counts.
  [[nodiscard]] virtual int work() const { return 0; }
};

}  // namespace tactor
