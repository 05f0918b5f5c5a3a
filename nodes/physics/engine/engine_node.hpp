// What the nodes have in common that step MuJoCo.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "framework/node/declare.hpp"
#include "nodes/physics/engine/coupled_engine.hpp"
#include "nodes/physics/engine/model_files.hpp"

namespace tactor {

/// The model that a node steps.
struct EngineParams {
  std::filesystem::path model;
  std::string tool;
  std::string keyframe;
  double substep = 0;  ///< s
};

/// Adds the model's parameters. `substep`: the default of the longest sub-step, s.
template <class N>
void declare_engine_model(Declare<N>& node, bool required, double substep) {
  using P = typename N::Params;
  // The template arguments let pointers to the members of the base class convert.
  node.file("model", &P::model, required, "the model, in MuJoCo's format MJCF (.xml)")
      .includes("model", model_files)
      .text("tool", &P::tool, "tool",
            "the body of the model that hangs on the coupling: a child of the world with a free joint, or with three "
            "slide joints")
      .text("keyframe", &P::keyframe, "",
            "the keyframe of the model to begin with, whose controls the actuators keep; empty: the model's own begin")
      .template real<double>("substep", &P::substep,
                             {.doc = "longest sub-step; it takes the place of the model's own time step",
                              .unit = "s",
                              .default_value = substep,
                              .min = 1e-5,
                              .max = 0.02,
                              .in_reference = 5e-5});
}

/// Loads MuJoCo and the model. Throws InputError where there is no plugin, and ValueError where the model cannot be
/// used or does not go with the scene: gravity is the model's, the tool has the mass of the model's, turns where that
/// does and then has its principal inertias to 5 %, and other moving bodies are in the model by their names. `type`: of
/// the node that asks, for messages. `partial`: as in EngineModel.
std::unique_ptr<CoupledEngine> load_engine(const std::string& type, const EngineParams& params,
                                           const NodeContext& context, bool partial = false);

/// What can be drawn of the model as it begins, and its tool for a graph whose scene has none, called `tool`. Its shape
/// is that of its only geom where a scene has such a shape, else a ball round all of them. Throw as load_engine does,
/// except for what does not go with a scene.
OwnScene model_scene(const std::string& type, const EngineParams& params);
OwnTool model_tool(const std::string& type, const EngineParams& params);

/// Notes which bodies of the model move without being in the scene.
void note_untold(const EngineParams& params, const CoupledEngine& engine, const NodeContext& context);

}  // namespace tactor
