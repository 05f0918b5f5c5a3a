#include "framework/graph/plan.hpp"
#include "framework/session/physics_loop.hpp"
#include "framework/session/session.hpp"

void step(tactor::Plan plan, const tactor::ExplicitTool& tool) {
  BLOCK;
}
