#include "framework/node/registry.hpp"
#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/hold.hpp"
#include "nodes/prediction/linear.hpp"
#include "nodes/prediction/refit.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::HoldPredictor>();
  registry.add<tactor::LinearPredictor>();
  registry.add<tactor::ArPredictor>();
  registry.add<tactor::Refitter>();
}
