// The messages that all stages of haptic rendering share: of fixed size, in SI units, with frames in the names.
//
// Frames: W world, D device handle, T tool (the moving body, origin at its centre of mass).
#pragma once

#include <array>
#include <cstdint>

#include "framework/core/message.hpp"
#include "framework/core/scene.hpp"
#include "framework/core/spatial.hpp"

namespace tactor {

template <>
const MessageType& message_type<Pose>();
template <>
const MessageType& message_type<Twist>();
template <>
const MessageType& message_type<Wrench>();

/// The pose at which a trajectory wants the hand.
struct Target {
  Pose X_WH;   ///< m
  Twist V_WH;  ///< m/s, rad/s
};

/// The state of the handle, as a device reports it.
struct DeviceState {
  Pose X_WD;   ///< m, as the encoder shows it
  Twist V_WD;  ///< m/s, rad/s, estimated by the device node
  std::int32_t buttons = 0;
};

/// The gripper of a device.
struct GripperState {
  double opening = 0;  ///< m between the fingers, larger where it is more open
  double speed = 0;    ///< m/s
};

/// What is wanted of a gripper's motor.
struct GripperForce {
  double force = 0;  ///< N, on the fingers; above zero it opens
};

/// What a device tells of itself beside its handle, in the order in which its node declares it.
struct HardwareStatus {
  static constexpr int capacity = 16;
  std::int32_t count = 0;                ///< entries of `value` in use
  std::array<double, capacity> value{};  ///< in the units of the declaration
};

/// The spring and damper between handle and tool. Force on the device: -k_t (p_WD - p_WT) - b_t (v_WD - v_WT);
/// the tool gets the opposite. Torque likewise with the rotation vector of R_WD R_WT^T.
struct CouplingParameters {
  double k_t = 0;             ///< N/m
  double b_t = 0;             ///< N s/m
  double k_r = 0;             ///< N m/rad
  double b_r = 0;             ///< N m s/rad
  double force_max = 0;       ///< N, by norm
  double torque_max = 0;      ///< N m, by norm
  std::int32_t massless = 0;  ///< 1: the tool is in quasi-static balance, its inertia is left out
};

/// The tool and the device at one instant of the simulated time, with what acts on the tool.
struct PhysicsState {
  Pose X_WT;                  ///< m
  Twist V_WT;                 ///< m/s, rad/s
  Pose X_WD;                  ///< m, the handle pose the step was computed against
  Twist V_WD;                 ///< m/s, rad/s
  Wrench contact_T_W;         ///< sum of the contacts on the tool, about the tool origin
  std::int32_t contacts = 0;  ///< contacts that carried force
  std::int32_t damped = 0;    ///< 1: the step did not converge, and contact_T_W is not what the contacts' law makes
};

/// Where the moving bodies of a scene are, in the order of Scene::moving(): the tool first.
struct BodyStates {
  static constexpr int capacity = max_moving_bodies;
  std::int32_t count = 0;
  std::int32_t massless = 0;         ///< 1: the tool was moved without its inertia, see CouplingParameters
  std::array<Pose, capacity> X_WB;   ///< m
  std::array<Twist, capacity> V_WB;  ///< m/s, rad/s
};

/// One contact of a moving body, here called T, with another body, linearised at the poses the query was made for.
struct Contact {
  Vec3 p_TC;             ///< m, the moving body's point in its own frame
  Vec3 p_WC;             ///< m, the nearest point of the other body's surface
  Vec3 n_W;              ///< unit, from the other body towards the moving one: the gradient of the distance
  double distance = 0;   ///< m, signed; negative inside: dot(n_W, p_W(moving body's point) - p_WC)
  double weight = 0;     ///< the share of a contact patch this point stands for; multiplies stiffness and damping
  double stiffness = 0;  ///< N/m for weight 1
  double damping = 0;    ///< N s/m for weight 1
  double friction = 0;   ///< Coulomb coefficient
  /// 1/m, the Hessian of the distance by the moving body's point, symmetric: xx, xy, xz, yy, yz, zz in W. Zero where
  /// the nearest feature is flat, and where it has no bound (on an edge or a corner itself).
  /// Where the moving body or the other one is a ball (a sphere, one of a capsule's), it is that of the distance as the
  /// ball's centre is moved without turning, not that of a point of its surface.
  std::array<double, 6> H_W{};
};

/// Who touches whom in a contact, as indices into Scene::moving().
struct ContactPair {
  static constexpr std::int32_t fixed = -1;  ///< any body that does not move
  std::int32_t body = 0;                     ///< the moving body: T of the contact
  std::int32_t other = fixed;
};

/// The contacts of one query: those that penetrate and those within its margin.
struct ContactSet {
  static constexpr int capacity = 128;
  BodyStates bodies;             ///< where the moving bodies were for the query (velocities are zero)
  std::int32_t count = 0;        ///< entries of `contact` and `pair` in use
  std::int32_t penetrating = 0;  ///< those with distance < 0
  std::int32_t truncated = 0;    ///< found and left out because the set was full
  std::array<Contact, capacity> contact;
  std::array<ContactPair, capacity> pair;
};

/// A physics force, and the forces expected at the next physics samples.
struct Forecast {
  static constexpr int capacity = 4;
  Wrench current_D_W;                          ///< on the device, valid at the message's stamp
  std::array<Wrench, capacity> predicted_D_W;  ///< on the device, [i - 1] expected at stamp + i horizon, i = 1 .. count
  double horizon = 0;                          ///< s, > 0, the estimated physics period
  std::int32_t count = 1;                      ///< entries of `predicted_D_W` in use, 1 to capacity
  std::int32_t fallback = 0;                   ///< 1: the predictor could not be used, and a hold replaces it
};

/// A force on the device as a quintic in time: F(t) = c[0] + c[1] s + ... + c[5] s^5 with s = (t - begin) / (end -
/// begin). Before `begin` it holds F(begin), after `end` it holds F(end).
/// Its message is stamped valid for the newest device sample that it was made from. So a pipeline that keeps sending
/// its last result is seen not to be fresh.
struct ForceSegment {
  Time begin;
  Time end;
  std::array<Wrench, 6> c{};
  /// The age of that sample beyond which the pipeline does not vouch for the force any longer; zero or less: not given.
  /// It can only shorten the time that a device allows.
  Duration trust_time;
};

/// How far the safety gate of a device lets the pipeline through.
enum class Engagement : std::int32_t {
  disengaged,  ///< zero is commanded
  ramping,     ///< the wrench comes in (cause none) or goes out (the cause says why)
  engaged,     ///< the pipeline's wrench within the limits
  fault,       ///< a brake or zero, until the inputs have been healthy for a while
};

/// Why a safety gate does not let the pipeline through.
enum class SafetyCause : std::int32_t {
  none,
  not_finite,         ///< fault: the pipeline's wrench was NaN or infinite
  overspeed,          ///< fault, after a brake: the device moved faster than its limit
  read_failed,        ///< fault: the device could not be read, or showed a state that is not finite
  write_failed,       ///< fault: the device did not take its wrench
  time_reversed,      ///< fault: a tick was earlier than the one before
  dead_man,           ///< the dead-man button was released
  stale,              ///< no fresh segment for too long
  not_permitted,      ///< the run is starting or stopping
  no_segment,         ///< no segment has come yet
  device_not_ready,   ///< the device has shown no state yet
  time_gap,           ///< a tick at the time of the one before, or long after it; counted, it changes no state
  outside_workspace,  ///< the handle is beyond the end of the device's workspace
  expired,  ///< the line let go of a command that was not renewed in time; the force comes back by the slew limit
};
/// The causes, `none` included.
inline constexpr int safety_cause_count = 14;

/// What the safety gate did at one tick.
struct SafetyState {
  Engagement engagement = Engagement::disengaged;
  SafetyCause cause = SafetyCause::none;  ///< why the wrench is kept out or ramps out
  double gain = 0;                        ///< of the ramp, 0 to 1
  Wrench clamped_D_W;                     ///< the pipeline's wrench within the limits, before ramp and slew limit
};

template <>
const MessageType& message_type<Target>();
template <>
const MessageType& message_type<DeviceState>();
template <>
const MessageType& message_type<GripperState>();
template <>
const MessageType& message_type<GripperForce>();
template <>
const MessageType& message_type<HardwareStatus>();
template <>
const MessageType& message_type<CouplingParameters>();
template <>
const MessageType& message_type<PhysicsState>();
template <>
const MessageType& message_type<BodyStates>();
template <>
const MessageType& message_type<Contact>();
template <>
const MessageType& message_type<ContactPair>();
template <>
const MessageType& message_type<ContactSet>();
template <>
const MessageType& message_type<Forecast>();
template <>
const MessageType& message_type<ForceSegment>();
template <>
const MessageType& message_type<SafetyState>();

}  // namespace tactor
