#include "framework/core/messages.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<Pose>() {
  static const MessageType type = Describe<Pose>("Pose").field("p", "m", &Pose::p).field("R", "1", &Pose::R).type();
  return type;
}

template <>
const MessageType& message_type<Twist>() {
  static const MessageType type =
      Describe<Twist>("Twist").field("v", "m/s", &Twist::v).field("w", "rad/s", &Twist::w).type();
  return type;
}

template <>
const MessageType& message_type<Wrench>() {
  static const MessageType type = Describe<Wrench>("Wrench", "W")
                                      .field("force", "N", &Wrench::force)
                                      .field("torque", "N m", &Wrench::torque)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<Target>() {
  static const MessageType type = Describe<Target>("Target", "W")
                                      .flat({"p_WH", "R_WH"}, &Target::X_WH)
                                      .flat({"v_WH", "w_WH"}, &Target::V_WH)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<DeviceState>() {
  static const MessageType type = Describe<DeviceState>("DeviceState", "W")
                                      .flat({"p_WD", "R_WD"}, &DeviceState::X_WD)
                                      .flat({"v_WD", "w_WD"}, &DeviceState::V_WD)
                                      .field("buttons", "1", &DeviceState::buttons)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<GripperState>() {
  static const MessageType type = Describe<GripperState>("GripperState")
                                      .field("opening", "m", &GripperState::opening)
                                      .field("speed", "m/s", &GripperState::speed)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<GripperForce>() {
  static const MessageType type =
      Describe<GripperForce>("GripperForce").field("force", "N", &GripperForce::force).type();
  return type;
}

template <>
const MessageType& message_type<HardwareStatus>() {
  static const MessageType type = Describe<HardwareStatus>("HardwareStatus")
                                      .field("count", "1", &HardwareStatus::count)
                                      .field("value", "1", &HardwareStatus::value)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<CouplingParameters>() {
  using C = CouplingParameters;
  static const MessageType type = Describe<C>("CouplingParameters")
                                      .field("k_t", "N/m", &C::k_t)
                                      .field("b_t", "N s/m", &C::b_t)
                                      .field("k_r", "N m/rad", &C::k_r)
                                      .field("b_r", "N m s/rad", &C::b_r)
                                      .field("force_max", "N", &C::force_max)
                                      .field("torque_max", "N m", &C::torque_max)
                                      .field("massless", "1", &C::massless)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<PhysicsState>() {
  using P = PhysicsState;
  static const MessageType type = Describe<P>("PhysicsState", "W")
                                      .flat({"p_WT", "R_WT"}, &P::X_WT)
                                      .flat({"v_WT", "w_WT"}, &P::V_WT)
                                      .flat({"p_WD", "R_WD"}, &P::X_WD)
                                      .flat({"v_WD", "w_WD"}, &P::V_WD)
                                      .flat({"contact_force", "contact_torque"}, &P::contact_T_W)
                                      .field("contacts", "1", &P::contacts)
                                      .field("damped", "1", &P::damped)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<BodyStates>() {
  static const MessageType type = Describe<BodyStates>("BodyStates", "W")
                                      .field("count", "1", &BodyStates::count)
                                      .field("massless", "1", &BodyStates::massless)
                                      .field("X_WB", &BodyStates::X_WB)
                                      .field("V_WB", &BodyStates::V_WB)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<Contact>() {
  static const MessageType type = Describe<Contact>("Contact", "W")
                                      .field("p_TC", "m", &Contact::p_TC)
                                      .frame("T")
                                      .field("p_WC", "m", &Contact::p_WC)
                                      .field("n_W", "1", &Contact::n_W)
                                      .field("distance", "m", &Contact::distance)
                                      .field("weight", "1", &Contact::weight)
                                      .field("stiffness", "N/m", &Contact::stiffness)
                                      .field("damping", "N s/m", &Contact::damping)
                                      .field("friction", "1", &Contact::friction)
                                      .field("H_W", "1/m", &Contact::H_W)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<ContactPair>() {
  static const MessageType type = Describe<ContactPair>("ContactPair")
                                      .field("body", "1", &ContactPair::body)
                                      .field("other", "1", &ContactPair::other)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<ContactSet>() {
  static const MessageType type = Describe<ContactSet>("ContactSet", "W")
                                      .field("bodies", &ContactSet::bodies)
                                      .field("count", "1", &ContactSet::count)
                                      .field("penetrating", "1", &ContactSet::penetrating)
                                      .field("truncated", "1", &ContactSet::truncated)
                                      .field("contact", &ContactSet::contact)
                                      .field("pair", &ContactSet::pair)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<Forecast>() {
  static const MessageType type = Describe<Forecast>("Forecast", "W")
                                      .flat({"current_force", "current_torque"}, &Forecast::current_D_W)
                                      .field("predicted", &Forecast::predicted_D_W)
                                      .field("horizon", "s", &Forecast::horizon)
                                      .field("count", "1", &Forecast::count)
                                      .field("fallback", "1", &Forecast::fallback)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<ForceSegment>() {
  static const MessageType type = Describe<ForceSegment>("ForceSegment", "W")
                                      .field("begin", &ForceSegment::begin)
                                      .field("end", &ForceSegment::end)
                                      .field("c", &ForceSegment::c)
                                      .field("trust_time", &ForceSegment::trust_time)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<SafetyState>() {
  using S = SafetyState;
  using enum SafetyCause;
  static const MessageType type = Describe<S>("SafetyState", "W")
                                      .choice("engagement", &S::engagement,
                                              {{"disengaged", Engagement::disengaged},
                                               {"ramping", Engagement::ramping},
                                               {"engaged", Engagement::engaged},
                                               {"fault", Engagement::fault}})
                                      .choice("cause", &S::cause,
                                              {{"none", none},
                                               {"not_finite", not_finite},
                                               {"overspeed", overspeed},
                                               {"read_failed", read_failed},
                                               {"write_failed", write_failed},
                                               {"time_reversed", time_reversed},
                                               {"dead_man", dead_man},
                                               {"stale", stale},
                                               {"not_permitted", not_permitted},
                                               {"no_segment", no_segment},
                                               {"device_not_ready", device_not_ready},
                                               {"time_gap", time_gap},
                                               {"outside_workspace", outside_workspace},
                                               {"expired", expired}})
                                      .field("gain", "1", &S::gain)
                                      .flat({"clamped_force", "clamped_torque"}, &S::clamped_D_W)
                                      .type();
  return type;
}

}  // namespace tactor
