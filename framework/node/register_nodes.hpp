// What a node library exports: `TACTOR_NODES(registry) { registry.add<MyNode>(); }` in one of its source files.
#pragma once

#include "framework/node/abi.hpp"
#include "framework/node/registry.hpp"
#include "tactor_abi.hpp"

// NOLINTBEGIN(bugprone-macro-parentheses): a parameter name cannot stand in parentheses.
#define TACTOR_NODES(registry) \
  TACTOR_STATES_ABI;           \
  extern "C" __attribute__((visibility("default"))) void tactor_register_nodes(::tactor::Registry& registry)
// NOLINTEND(bugprone-macro-parentheses)
