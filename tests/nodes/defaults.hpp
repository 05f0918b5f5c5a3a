// Makes nodes with their declared defaults, so that tests name only what they change.
#pragma once

#include <memory>

#include "framework/node/info.hpp"

namespace tactor::test {

template <class N>
typename N::Params default_params() {
  typename N::Params params{};
  for (const ParamInfo& p : N::declare().params) p.assign(&params, p.default_value.value());
  return params;
}

inline NodeContext context_for(const Scene& scene) {
  NodeContext context;
  context.name = "test";
  context.scene = &scene;
  context.torque = scene.rotates();
  return context;
}

/// The message number i that the running step has sent.
template <class T>
const T& sent(const Output<T>& out, std::size_t i = 0) {
  return *static_cast<const T*>(out.pending_value(i));
}

}  // namespace tactor::test
