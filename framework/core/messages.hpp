// The messages that all stages of haptic rendering share: of fixed size, in SI units, with frames in the names. Their
// descriptions in messages.cpp say what each field means; docs/reference/message_types.md shows them.
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

/// The wanted state of the hand.
struct Target {
  Pose X_WH;   ///< m
  Twist V_WH;  ///< m/s, rad/s
};

/// The state of the handle.
struct DeviceState {
  Pose X_WD;   ///< m
  Twist V_WD;  ///< m/s, rad/s
  std::int32_t buttons = 0;
};

/// The state of a gripper.
struct GripperState {
  double opening = 0;  ///< m
  double speed = 0;    ///< m/s
};

/// The wanted force of a gripper.
struct GripperForce {
  double force = 0;  ///< N
};

/// Other readings of a device.
struct HardwareStatus {
  static constexpr int capacity = 16;
  std::int32_t count = 0;
  std::array<double, capacity> value{};
};

/// The spring and damper between handle and tool.
struct CouplingParameters {
  double k_t = 0;         ///< N/m
  double b_t = 0;         ///< N s/m
  double k_r = 0;         ///< N m/rad
  double b_r = 0;         ///< N m s/rad
  double force_max = 0;   ///< N
  double torque_max = 0;  ///< N m
  std::int32_t massless = 0;
};

/// The result of a step of physics.
struct PhysicsState {
  Pose X_WT;           ///< m
  Twist V_WT;          ///< m/s, rad/s
  Pose X_WD;           ///< m
  Twist V_WD;          ///< m/s, rad/s
  Wrench contact_T_W;  ///< N, N m
  std::int32_t contacts = 0;
  std::int32_t damped = 0;
};

/// The states of the moving bodies, in the order of Scene::moving().
struct BodyStates {
  static constexpr int capacity = max_moving_bodies;
  std::int32_t count = 0;
  std::int32_t massless = 0;
  std::array<Pose, capacity> X_WB;   ///< m
  std::array<Twist, capacity> V_WB;  ///< m/s, rad/s
};

/// A contact of a moving body, here called T.
struct Contact {
  Vec3 p_TC;                    ///< m
  Vec3 p_WC;                    ///< m
  Vec3 n_W;                     ///< unit
  double distance = 0;          ///< m
  double weight = 0;            ///< share of a patch
  double stiffness = 0;         ///< N/m for weight 1
  double damping = 0;           ///< N s/m for weight 1
  double friction = 0;          ///< Coulomb coefficient
  double inertia = 0;           ///< kg for weight 1
  double creep = 0;             ///< s/kg for weight 1; 0: the step's
  double lift = 0;              ///< 0 to 1
  std::array<double, 6> H_W{};  ///< 1/m
};

/// The two bodies of a contact, as indices into Scene::moving().
struct ContactPair {
  static constexpr std::int32_t fixed = -1;  ///< any body that does not move
  std::int32_t body = 0;
  std::int32_t other = fixed;
};

/// The contacts of one query.
struct ContactSet {
  static constexpr int capacity = 128;
  BodyStates bodies;
  std::int32_t count = 0;
  std::int32_t penetrating = 0;
  std::int32_t truncated = 0;
  std::array<Contact, capacity> contact;
  std::array<ContactPair, capacity> pair;
};

/// A physics force and the forces expected next.
struct Forecast {
  static constexpr int capacity = 4;
  Wrench current_D_W;                          ///< N, N m
  std::array<Wrench, capacity> predicted_D_W;  ///< N, N m
  double horizon = 0;                          ///< s
  std::int32_t count = 1;
  std::int32_t fallback = 0;
};

/// A force on the device as a quintic in time; see segment.hpp.
struct ForceSegment {
  Time begin;
  Time end;
  std::array<Wrench, 6> c{};  ///< N, N m
  Duration trust_time;
};

/// How far the safety gate of a device lets the pipeline through.
enum class Engagement : std::int32_t { disengaged, ramping, engaged, fault };

/// Why a safety gate does not let the pipeline through.
enum class SafetyCause : std::int32_t {
  none,
  not_finite,
  overspeed,
  read_failed,
  write_failed,
  time_reversed,
  dead_man,
  stale,
  not_permitted,
  no_segment,
  device_not_ready,
  time_gap,
  outside_workspace,
  expired,
};
/// The causes, `none` included.
inline constexpr int safety_cause_count = 14;

/// The safety gate at one tick.
struct SafetyState {
  Engagement engagement = Engagement::disengaged;
  SafetyCause cause = SafetyCause::none;
  double gain = 0;     ///< 0 to 1
  Wrench clamped_D_W;  ///< N, N m
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
