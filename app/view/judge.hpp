// A follower for any session: where its plan has no sink that compares, one is thought of.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "framework/session/follower.hpp"

namespace tactor {

/// A follower that compares what the device displays with what physics without delay gives. Null, with a note, where
/// nothing can follow the run.
std::unique_ptr<Follower> judging_follower(Session& session, Registry& registry, std::optional<Duration> most_behind,
                                           const std::function<void(const std::string&)>& note);

}  // namespace tactor
