// Bad input of which one value of a graph is the cause, so that the error can point at where that value was written.
#pragma once

#include <string>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

/// As InputError. path(): the value that the user is to change, `scene.bodies.tool.mesh`, or a parameter of the node
/// that throws it (`file`). Whoever makes the node puts the place in front of the message.
class ValueError : public InputError {
 public:
  ValueError(std::string path, const std::string& message) : InputError(message), path_(std::move(path)) {}
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Calls `work`, and what it refuses is about the value `path`, unless it says itself what it is about.
template <class Work>
auto about(const std::string& path, const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const ValueError&) {
    throw;
  } catch (const InputError& error) {
    throw ValueError(path, error.what());
  }
}

}  // namespace tactor
