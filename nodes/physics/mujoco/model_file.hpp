// Reads a model of MuJoCo and hangs one of its bodies on the coupling.
#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "nodes/physics/engine/coupled_engine.hpp"
#include "nodes/physics/engine/mujoco_plugin.hpp"

namespace tactor {

struct MujocoDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPointer = std::unique_ptr<mjModel, MujocoDeleter>;
using DataPointer = std::unique_ptr<mjData, MujocoDeleter>;

/// The model, which all readers share as long as its files stay as they are, with one more equality, the last one,
/// which welds the tool to the world: its rows in the solver become those of the coupling. Throws ValueError about
/// `model` or `tool` where the file is no model that MuJoCo reads, it has no such body, or the coupling cannot move
/// that body.
std::shared_ptr<const mjModel> read_coupled_model(const EngineModel& model);

/// The bodies of a model, but for the world and those without a name. Throws ValueError about `model` where MuJoCo
/// cannot read the file, or the coupling can move no body of it.
std::vector<ModelBody> model_bodies(const std::filesystem::path& file);

}  // namespace tactor
