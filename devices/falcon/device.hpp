// falcon.device: a Novint Falcon.
#pragma once

#include <filesystem>
#include <string>

#include "devices/hardware/declare_hardware.hpp"

namespace tactor {

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
};

}  // namespace tactor
