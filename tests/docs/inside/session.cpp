#include "framework/session/session.hpp"
#include "framework/core/messages.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "framework/session/add_feed.hpp"
#include "framework/yaml/file_finder.hpp"

void lead() {
  BLOCK;
}
