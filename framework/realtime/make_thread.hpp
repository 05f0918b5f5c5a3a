// Makes threads, and says which limit stands in the way where the system gives none.
#pragma once

#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

/// The message for a thread or process `what` that the system refused with `error`, an errno: the limits that this
/// process has on threads, processes and memory, and what to do.
std::string refused_start(const std::string& what, int error);

/// A thread that runs `work`. Throws RunError, with `name` and the limits, where the system gives none.
template <class Work>
std::thread make_thread(const std::string& name, Work&& work) {
  try {
    return std::thread(std::forward<Work>(work));
  } catch (const std::system_error& error) {
    throw RunError(refused_start("thread " + name, error.code().value()));
  }
}

}  // namespace tactor
