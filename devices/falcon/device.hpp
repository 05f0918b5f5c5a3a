// falcon.device: a Novint Falcon.
#pragma once

#include <filesystem>
#include <string>

#include "devices/hardware/declare_hardware.hpp"

namespace tactor {

class FalconLink;

/// See HardwareDevice and FalconLink. A device that needs a firmware and is given none does not start: `start` throws
/// InputError.
class Falcon final : public HardwareDevice {
 public:
  struct Params : HardwareParams {
    std::filesystem::path firmware;
    std::string serial;
    std::string file;
  };
  Falcon(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  void start(StepContext& context) override;
  void follow(const Node& tested) override;

 private:
  struct Parts;
  Falcon(const Params& params, const NodeContext& context, Parts parts);

  FalconLink* link_;  // the runner's; touched by `start` alone, before its thread is made
  bool follows_ = false;
};

}  // namespace tactor
