// fault.device: a device in software whose reading fails, blocks or jumps at a given time.
#pragma once

#include "framework/realtime/declare_device.hpp"
#include "tests/fault_nodes/passing.hpp"

namespace tactor::fault {

/// Its handle is where the target says; its velocity is the difference of two ticks.
class Device final : public DeviceNode {
 public:
  enum class Fault { fails, blocks, jumps };
  struct Params : DeviceParams, When {
    Fault fault = Fault::fails;
  };
  Device(const Params& params, const NodeContext& context) : DeviceNode(params, context), params_(params) {}
  static NodeInfo declare();

  Input<Target> target;

 protected:
  ReadResult read(Time now, DeviceSample& sample) noexcept override;
  bool write(Time now, const Wrench& commanded_D_W) noexcept override;
  [[nodiscard]] const char* failure() const noexcept override { return "its cable is out on purpose"; }

 private:
  Params params_;
  bool blocked_ = false;
  bool any_ = false;
  Time last_;
  Vec3 p_WD_;  // m, at the last tick
};

}  // namespace tactor::fault
