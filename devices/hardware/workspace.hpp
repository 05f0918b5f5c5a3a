// Where the base of a device stands in the scene, and how large its motion is there.
#pragma once

#include "framework/core/spatial.hpp"

namespace tactor {

/// The map from the base B of a device to the scene W: p_WD = p_WB + scale R_WB p_BD, R_WD = R_WB R_BD. Forces go back
/// by F_B = force_scale R_WB^T F_W. The power at the handle is that in the scene where force_scale equals scale; with
/// another force_scale a passive scene may feel active at the handle.
struct Workspace {
  double scale = 1;        ///< m in the scene a m of the device
  double force_scale = 1;  ///< N at the device a N in the scene
  Quat R_WB;
  Vec3 p_WB;  ///< m

  [[nodiscard]] Pose to_scene(const Pose& X_BD) const { return {p_WB + scale * rotate(R_WB, X_BD.p), R_WB * X_BD.R}; }
  [[nodiscard]] Wrench to_device(const Wrench& F_D_W) const {
    const Quat R_BW = inverse(R_WB);
    return {force_scale * rotate(R_BW, F_D_W.force), force_scale * rotate(R_BW, F_D_W.torque)};
  }
};

}  // namespace tactor
