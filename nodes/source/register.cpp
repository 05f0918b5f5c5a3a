#include "framework/node/register_nodes.hpp"
#include "nodes/source/feed.hpp"
#include "nodes/source/physics.hpp"
#include "nodes/source/recording.hpp"
#include "nodes/source/trajectory.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::FeedSource>();
  registry.add<tactor::PhysicsSource>();
  registry.add<tactor::RecordingSource>();
  registry.add<tactor::TrajectorySource>();
}
