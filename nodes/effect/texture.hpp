// effect.texture: the vibration of a tool that slides over a rough surface.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <filesystem>

#include "nodes/effect/contact.hpp"
#include "nodes/effect/stage.hpp"
#include "nodes/effect/texture_model.hpp"

namespace tactor {

/// While the tool touches (touch_of) with the force F (N, W), its direction is taken for the surface's normal n and its
/// size for the normal force, and what the handle's velocity has across n for the sliding. With friction in F, n leans
/// by the friction angle. TextureModel says at that speed and force how the tool vibrates: white noise through
/// the filter there makes its acceleration a (m/s^2). Added is gain * mass * a, in N, along n, along the motion, or
/// across both. Noise is drawn from the node's seed, so that a run can be made again.
/// Throws YamlError where the file is no model, InputError where the model's samples come faster than the ticks.
class Texture final : public Node {
 public:
  enum class Along { normal, motion, across };
  struct Params {
    std::filesystem::path file;
    Along along = Along::normal;
    double gain = 0;
    double mass = 0;       ///< kg
    double threshold = 0;  ///< N
    double force_max = 0;  ///< N
    double rate = 0;       ///< Hz
  };
  Texture(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<ForceSegment> base;
  Input<DeviceState> device;
  Input<PhysicsState> contact;
  Output<ForceSegment> segment;

 private:
  void make_samples(Time now, double speed, double force);
  [[nodiscard]] Vec3 direction(const Vec3& n, const Vec3& sliding) const;

  Params params_;
  TextureModel model_;
  EffectStage stage_;
  boost::random::mt19937_64 engine_;
  boost::random::normal_distribution<double> noise_;
  NormalisedLattice lattice_;
  std::int64_t samples_ = -1;  // the number of the newest, from time zero on
  double acceleration_ = 0;    // m/s^2, of that
  double squares_ = 0, largest_ = 0;
  std::int64_t ticks_ = 0, limited_ticks_ = 0;
};

}  // namespace tactor
