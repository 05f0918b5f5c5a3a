// device.mouse: the cursor of a person as a haptic device that cannot push back.
#pragma once

#include <vector>

#include "devices/mouse/cursor.hpp"
#include "devices/mouse/cursor_filter.hpp"
#include "framework/node/info.hpp"
#include "framework/realtime/device_node.hpp"

namespace tactor {

/// The handle follows the cursor. What is commanded moves nothing: who shows the cursor shows the force.
///
/// Button 1 is held while the cursor says so, and released where no cursor has come for `heartbeat_timeout`. After that
/// a cursor must come that is not held before one that is counts again: who comes back comes back disengaged.
class MouseDevice final : public DeviceNode {
 public:
  struct Params : DeviceParams {
    std::vector<double> start;           ///< m, where the handle is before the first cursor
    std::vector<double> start_rotation;  ///< rad, rotation vector
    double time_constant = 0;            ///< s
    double follow_speed = 0;             ///< m/s
    double follow_angular_speed = 0;     ///< rad/s
    Duration heartbeat_timeout;
  };

  /// Throws InputError where the handle may follow faster than the safety gate lets it.
  MouseDevice(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  Input<Cursor> cursor;

 protected:
  ReadResult read(Time now, DeviceSample& sample) noexcept override;
  bool write(Time now, const Wrench& commanded_D_W) noexcept override;
  [[nodiscard]] const char* failure() const noexcept override;

 private:
  [[nodiscard]] bool is_held(Time now);

  Duration heartbeat_timeout_;
  Pose start_;
  CursorFilter filter_;
  bool started_ = false;
  Time last_;
  bool was_held_ = false;
  bool must_release_ = false;
  std::uint64_t timeouts_ = 0;
};

}  // namespace tactor
