#include "framework/node/register_nodes.hpp"
#include "nodes/interpolation/blend.hpp"
#include "nodes/interpolation/bspline.hpp"
#include "nodes/interpolation/catmull_rom.hpp"
#include "nodes/interpolation/direct.hpp"
#include "nodes/interpolation/external.hpp"
#include "nodes/interpolation/gain.hpp"
#include "nodes/interpolation/hermite.hpp"
#include "nodes/interpolation/linear.hpp"
#include "nodes/interpolation/lowpass.hpp"
#include "nodes/interpolation/mujoco.hpp"
#include "nodes/interpolation/none.hpp"
#include "nodes/interpolation/rollout.hpp"
#include "nodes/interpolation/select.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::NoInterpolation>();
  registry.add<tactor::LinearInterpolation>();
  registry.add<tactor::LowPass>();
  registry.add<tactor::BSpline>();
  registry.add<tactor::Rollout>();
  registry.add<tactor::MujocoRollout>();
  registry.add<tactor::ExternalRollout>();
  registry.add<tactor::Direct>();
  registry.add<tactor::CatmullRom>();
  registry.add<tactor::HermiteCubic>();
  registry.add<tactor::HermiteQuintic>();
  registry.add<tactor::Blend>();
  registry.add<tactor::Select>();
  registry.add<tactor::Gain>();
}
