#include "devices/mouse/mouse.hpp"

#include <cmath>

#include "framework/core/check.hpp"
#include "framework/realtime/declare_device.hpp"

namespace tactor {

namespace {

Pose start_of(const MouseDevice::Params& params) {
  const std::vector<double>& p = params.start;
  const std::vector<double>& r = params.start_rotation;
  return {{p[0], p[1], p[2]}, from_rotation_vector({r[0], r[1], r[2]})};
}

bool is_pose(const Pose& X) {
  const Quat& q = X.R;
  const double square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return is_finite(X.p) && std::isfinite(square) && std::abs(square - 1.0) < 1e-3;
}

}  // namespace

MouseDevice::MouseDevice(const Params& params, const NodeContext& context)
    : DeviceNode(params, context, 1),
      heartbeat_timeout_(params.heartbeat_timeout),
      start_(start_of(params)),
      filter_({params.time_constant, params.follow_speed, params.follow_angular_speed}, start_) {
  if (params.follow_speed >= params.speed_max || params.follow_angular_speed >= params.angular_speed_max) {
    throw InputError("node " + context.name +
                     ": expected follow_speed below speed_max and follow_angular_speed below angular_speed_max; "
                     "otherwise the safety gate brakes a cursor that is moved fast");
  }
}

NodeInfo MouseDevice::declare() {
  using D = MouseDevice;
  DeviceParams defaults;
  defaults.dead_man_button = 1;
  Declare<D> declaration("device.mouse", "Uses a person's cursor as a haptic device that cannot push back.");
  declaration
      .details(
          "The handle follows the cursor through a critically damped filter of second order, no faster than "
          "follow_speed. The commanded force moves nothing; `tactor view`, which sends the cursor, displays it. The "
          "cursor is also the dead-man button. It counts as released while the person does not hold the handle, and "
          "when no cursor has come for heartbeat_timeout. After such a timeout, the person must let go and take hold "
          "again.")
      .input("cursor", &D::cursor, {.doc = "the pose at which the person wants the handle, and whether they hold it"});
  declare_device(declaration, defaults);
  declaration
      .metric("device.released_by_timeout", "1", "times that a held cursor stopped coming", Better::lower,
              &MouseDevice::timeouts_)
      .reals("start", &Params::start, 3, std::vector<double>{0, 0, 0},
             {.doc = "position of the handle before the first cursor", .unit = "m", .min = -1e3, .max = 1e3})
      .reals("start_rotation", &Params::start_rotation, 3, std::vector<double>{0, 0, 0},
             {.doc = "rotation vector of the handle before the first cursor", .unit = "rad", .min = -7, .max = 7})
      .real(
          "time_constant", &Params::time_constant,
          {.doc =
               "time constant of the filter between cursor and handle. Cursors come 60 to 250 times a second, unevenly",
           .unit = "s",
           .default_value = 0.01,
           .min = 1e-3,
           .max = 1})
      .real("follow_speed", &Params::follow_speed,
            {.doc = "largest speed at which the handle follows the cursor",
             .unit = "m/s",
             .default_value = 0.5,
             .min = 1e-3,
             .max = 100})
      .real("follow_angular_speed", &Params::follow_angular_speed,
            {.doc = "largest angular speed at which the handle follows the cursor",
             .unit = "rad/s",
             .default_value = 6,
             .min = 1e-3,
             .max = 1000})
      .real("heartbeat_timeout", &Params::heartbeat_timeout,
            {.doc = "the handle counts as released after this time without a cursor",
             .unit = "s",
             .default_value = 0.2,
             .min = 0.01,
             .max = 1});
  return declaration.info();
}

bool MouseDevice::is_held(Time now) {
  const Stamped<Cursor>* newest = cursor.latest();
  if (newest == nullptr) return false;
  if (now - newest->stamp.produced > heartbeat_timeout_) {
    if (was_held_) ++timeouts_;
    must_release_ = true;
    return false;
  }
  if (newest->value.held == 0) must_release_ = false;
  return newest->value.held != 0 && !must_release_;
}

ReadResult MouseDevice::read(Time now, DeviceSample& sample) noexcept {
  const Stamped<Cursor>* newest = cursor.latest();
  const Pose to = newest == nullptr ? start_ : newest->value.X_WC;
  if (!is_pose(to)) return ReadResult::failed;
  if (started_) filter_.advance(std::max((now - last_).seconds(), 0.0), to, rotates());
  started_ = true;
  last_ = now;
  was_held_ = is_held(now);
  sample.state.X_WD = filter_.state().X;
  sample.state.V_WD = filter_.state().V;
  sample.state.buttons = was_held_ ? 1 : 0;
  sample.time = now;
  return ReadResult::sample;
}

bool MouseDevice::write(Time, const Wrench&) noexcept {
  return true;
}

const char* MouseDevice::failure() const noexcept {
  return "the cursor is not a valid pose";
}

}  // namespace tactor
