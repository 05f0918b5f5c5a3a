// source.feed: an output that a program fills while the run goes on.
#pragma once

#include <string>

#include "framework/node/info.hpp"

namespace tactor {

/// Has no step: a session sends for it (Session::feed).
class FeedSource final : public Node {
 public:
  struct Params {
    std::string message;
  };
  FeedSource(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& /*context*/) override {}

  AnyOutput message;
};

}  // namespace tactor
