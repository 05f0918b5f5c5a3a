#include "framework/node/register_nodes.hpp"
#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/external.hpp"
#include "nodes/prediction/hold.hpp"
#include "nodes/prediction/kalman.hpp"
#include "nodes/prediction/linear.hpp"
#include "nodes/prediction/linear_position.hpp"
#include "nodes/prediction/local.hpp"
#include "nodes/prediction/mujoco.hpp"
#include "nodes/prediction/multirate.hpp"
#include "nodes/prediction/refit.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::HoldPredictor>();
  registry.add<tactor::LinearPredictor>();
  registry.add<tactor::LinearPositionPredictor>();
  registry.add<tactor::KalmanPredictor>();
  registry.add<tactor::MultiratePredictor>();
  registry.add<tactor::ArPredictor>();
  registry.add<tactor::Refitter>();
  registry.add<tactor::LocalPredictor>();
  registry.add<tactor::MujocoPredictor>();
  registry.add<tactor::ExternalPredictor>();
}
