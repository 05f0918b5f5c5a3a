// Bad input caused by one value of a graph, so that the error can point at the place of that value.
#pragma once

#include <string>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

/// Like InputError. path(): the value that the user has to change, `scene.bodies.tool.mesh`, or a parameter of the node
/// that throws it (`file`). The code that makes the node puts the place in front of the message.
class ValueError : public InputError {
 public:
  ValueError(std::string path, const std::string& message) : InputError(message), path_(std::move(path)) {}
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Calls `work`. An InputError that it throws becomes a ValueError about `path`, unless it is a ValueError already.
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
