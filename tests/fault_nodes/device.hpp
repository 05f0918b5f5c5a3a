// fault.device: a device in software whose reading fails, blocks or jumps at a given time.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "framework/realtime/declare_device.hpp"
#include "tests/fault_nodes/passing.hpp"

namespace tactor::fault {

/// Its handle is where the target says; its velocity is the difference of two ticks.
class Device final : public DeviceNode {
 public:
  enum class Fault { fails, blocks, jumps };
  struct Params : DeviceParams, When {
    Fault fault = Fault::fails;
    std::string log;
  };
  Device(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  /// Writes the file `log`: the time in ns and the force in N of each tick, for runs that cannot record to their end.
  void report(Report& report) const override;

  Input<Target> target;

 protected:
  ReadResult read(Time now, DeviceSample& sample) noexcept override;
  bool write(Time now, const Wrench& commanded_D_W) noexcept override;
  [[nodiscard]] const char* failure() const noexcept override { return "its cable is out on purpose"; }

 private:
  Params params_;
  bool done_ = false;  // the first wrong reading has been
  bool any_ = false;
  Time last_;
  Vec3 p_WD_;                                   // m, at the last tick
  std::vector<std::pair<Time, Vec3>> written_;  // never beyond its reserve
};

}  // namespace tactor::fault
