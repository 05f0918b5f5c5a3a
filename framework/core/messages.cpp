#include "framework/core/messages.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<Pose>() {
  static const MessageType type =
      Describe<Pose>("Pose", "", "The pose of a frame B in a frame A.")
          .field("p", "m", &Pose::p,
                 "Position of the origin of B, measured from the origin of A (the world in `X_WB`).")
          .field("R", "1", &Pose::R,
                 "Unit quaternion w, x, y, z: it rotates vectors expressed in B to A (the world in `X_WB`).")
          .type();
  return type;
}

template <>
const MessageType& message_type<Twist>() {
  static const MessageType type = Describe<Twist>("Twist", "", "The velocity of a frame B in a frame A.")
                                      .field("v", "m/s", &Twist::v, "Velocity of the origin of B.")
                                      .field("w", "rad/s", &Twist::w, "Angular velocity of B, by the right-hand rule.")
                                      .type();
  return type;
}

template <>
const MessageType& message_type<Wrench>() {
  static const MessageType type =
      Describe<Wrench>("Wrench", "W",
                       "A force and a torque on a body. Every wrench that shipped nodes exchange acts on the device, "
                       "never on the tool. Stamped valid for the state or the tick that it was computed for.")
          .field("force", "N", &Wrench::force, "Force on the body.")
          .field("torque", "N m", &Wrench::torque,
                 "Torque on the body about the origin of its frame, by the right-hand rule; for the device that is the "
                 "origin of the handle D.")
          .type();
  return type;
}

template <>
const MessageType& message_type<Target>() {
  static const MessageType type =
      Describe<Target>("Target", "W",
                       "The pose and velocity that a trajectory wants of the hand H. Stamped valid for the time at "
                       "which they are wanted.")
          .flat({{"p_WH", "Position of the origin of H, measured from the origin of W."},
                 {"R_WH", "Unit quaternion w, x, y, z: it rotates vectors expressed in H to W."}},
                &Target::X_WH)
          .flat({{"v_WH", "Velocity of the origin of H."}, {"w_WH", "Angular velocity of H, by the right-hand rule."}},
                &Target::V_WH)
          .type();
  return type;
}

template <>
const MessageType& message_type<DeviceState>() {
  static const MessageType type =
      Describe<DeviceState>("DeviceState", "W",
                            "The handle D of a device, as the device reports it. Stamped valid for the time at which "
                            "the device took the sample.")
          .flat({{"p_WD", "Position of the origin of D, measured from the origin of W, as the encoders show it."},
                 {"R_WD", "Unit quaternion w, x, y, z: it rotates vectors expressed in D to W."}},
                &DeviceState::X_WD)
          .flat({{"v_WD", "Velocity of the origin of D, estimated by the device node."},
                 {"w_WD", "Angular velocity of D, by the right-hand rule, estimated by the device node."}},
                &DeviceState::V_WD)
          .field("buttons", "1", &DeviceState::buttons,
                 "One bit a button, 1 while it is pressed. The first button is the lowest bit.")
          .type();
  return type;
}

template <>
const MessageType& message_type<GripperState>() {
  static const MessageType type =
      Describe<GripperState>("GripperState", "",
                             "The gripper of a device. Stamped valid for the time at which the device was read.")
          .field("opening", "m", &GripperState::opening, "Distance between the fingers; it grows as they open.")
          .field("speed", "m/s", &GripperState::speed, "Rate of `opening`: positive while the fingers part.")
          .type();
  return type;
}

template <>
const MessageType& message_type<GripperForce>() {
  static const MessageType type =
      Describe<GripperForce>("GripperForce", "",
                             "The force that is wanted of a gripper's motor. It holds from its stamp until the next "
                             "one, at most for the time `stale_after` of the device.")
          .field("force", "N", &GripperForce::force, "Force on the fingers: a positive one opens them.")
          .type();
  return type;
}

template <>
const MessageType& message_type<HardwareStatus>() {
  static const MessageType type =
      Describe<HardwareStatus>("HardwareStatus", "",
                               "Readings of a device besides its handle, sent when one of them changes. Stamped valid "
                               "for the time at which the device was read.")
          .field("count", "1", &HardwareStatus::count, "Entries of `value` in use.")
          .field("value", "1", &HardwareStatus::value,
                 "The readings, in the order and in the units that the output of the device node names.")
          .type();
  return type;
}

template <>
const MessageType& message_type<CouplingParameters>() {
  using C = CouplingParameters;
  static const MessageType type =
      Describe<C>("CouplingParameters", "",
                  "The spring and damper between handle D and tool T. Force on the device: -k_t (p_WD - p_WT) - b_t "
                  "(v_WD - v_WT). Torque on the device: -k_r r - b_r (w_WD - w_WT), with r the rotation vector of R_WD "
                  "R_WT^T the shorter way round. The tool gets the opposite. Stamped valid for the time from which "
                  "they hold.")
          .field("k_t", "N/m", &C::k_t, "Stiffness of the spring between the positions of handle and tool.")
          .field("b_t", "N s/m", &C::b_t, "Damping of the velocity of the handle against that of the tool.")
          .field("k_r", "N m/rad", &C::k_r, "Stiffness of the spring between the orientations of handle and tool.")
          .field("b_r", "N m s/rad", &C::b_r, "Damping of the angular velocity of the handle against that of the tool.")
          .field("force_max", "N", &C::force_max,
                 "Largest norm of the force on the device. A longer one is shortened to it; the tool gets the whole.")
          .field("torque_max", "N m", &C::torque_max,
                 "Largest norm of the torque on the device. A longer one is shortened to it; the tool gets the whole.")
          .field("massless", "1", &C::massless,
                 "1: the tool has no inertia, no weight and no damper, and goes to where the springs balance. 0: it "
                 "moves by its mass.")
          .type();
  return type;
}

template <>
const MessageType& message_type<PhysicsState>() {
  using P = PhysicsState;
  static const MessageType type =
      Describe<P>("PhysicsState", "W",
                  "The tool T after a step of physics, and the handle D that the step was computed against. Stamped "
                  "valid for the device sample of that handle.")
          .flat({{"p_WT", "Position of the origin of T, its centre of mass, measured from the origin of W."},
                 {"R_WT", "Unit quaternion w, x, y, z: it rotates vectors expressed in T to W."}},
                &P::X_WT)
          .flat({{"v_WT", "Velocity of the origin of T."}, {"w_WT", "Angular velocity of T, by the right-hand rule."}},
                &P::V_WT)
          .flat({{"p_WD", "Position of the origin of D, measured from the origin of W."},
                 {"R_WD", "Unit quaternion w, x, y, z: it rotates vectors expressed in D to W."}},
                &P::X_WD)
          .flat({{"v_WD", "Velocity of the origin of D."}, {"w_WD", "Angular velocity of D, by the right-hand rule."}},
                &P::V_WD)
          .flat({{"contact_force", "Sum of the forces of all contacts on the tool, without coupling and weight."},
                 {"contact_torque", "Sum of their torques on the tool, about the origin of T."}},
                &P::contact_T_W)
          .field("contacts", "1", &P::contacts, "Contacts of the tool that carry force.")
          .field("damped", "1", &P::damped,
                 "1: the step did not converge, and the contact force is not that of the contact law. 0: it converged.")
          .type();
  return type;
}

template <>
const MessageType& message_type<BodyStates>() {
  static const MessageType type =
      Describe<BodyStates>("BodyStates", "W",
                           "The moving bodies of a scene: the tool first, then the others in the order of the graph "
                           "file. Stamped valid for the time at which they are there.")
          .field("count", "1", &BodyStates::count, "Moving bodies: entries of `X_WB` and `V_WB` in use.")
          .field("massless", "1", &BodyStates::massless,
                 "1: the tool was moved without its inertia, as CouplingParameters tells. 0: with it.")
          .field("X_WB", &BodyStates::X_WB, "Pose of each body B in the world.")
          .field("V_WB", &BodyStates::V_WB, "Velocity of each body B in the world.")
          .type();
  return type;
}

template <>
const MessageType& message_type<Contact>() {
  static const MessageType type =
      Describe<Contact>("Contact", "W",
                        "A contact of a moving body T with another body, linearised at the poses of the query.")
          .field("p_TC", "m", &Contact::p_TC, "Contact point of the moving body, measured from its origin.")
          .frame("T")
          .field("p_WC", "m", &Contact::p_WC,
                 "Contact point of the other body: the nearest one of its surface, measured from the origin of W.")
          .field("n_W", "1", &Contact::n_W,
                 "Unit normal from the other body towards the moving body T. It is the gradient of `distance`.")
          .field("distance", "m", &Contact::distance,
                 "Distance from `p_WC` to the moving body's point along `n_W`: positive apart, negative inside.")
          .field("weight", "1", &Contact::weight,
                 "Share of a contact patch that this contact stands for. It multiplies all forces of the contact.")
          .field("stiffness", "N/m", &Contact::stiffness,
                 "Stiffness at weight 1: those of the two materials in series, 1 / (1/a + 1/b).")
          .field("damping", "N s/m", &Contact::damping, "Damping at weight 1: that of the softer material.")
          .field("friction", "1", &Contact::friction,
                 "Coulomb coefficient: the geometric mean of those of the two materials.")
          .field("inertia", "kg", &Contact::inertia,
                 "Mass at weight 1 that the contact adds against acceleration along `n_W`. With it, damping acts only "
                 "where the bodies overlap.")
          .field("creep", "s/kg", &Contact::creep,
                 "Speed per force at weight 1 at which static friction gives way; 0: as the step has it.")
          .field("lift", "1", &Contact::lift,
                 "Sliding at a speed u beyond the creep adds lift * damping * friction * u to the normal force.")
          .field("H_W", "1/m", &Contact::H_W,
                 "Hessian of `distance` by the moving body's point, symmetric: xx, xy, xz, yy, yz, zz. It is zero "
                 "where the nearest feature is flat, and on an edge or a corner itself. Where one of the two is a ball "
                 "(a sphere, or one of a capsule's), it is that for moving the ball's centre without turning.")
          .type();
  return type;
}

template <>
const MessageType& message_type<ContactPair>() {
  static const MessageType type =
      Describe<ContactPair>("ContactPair", "",
                            "The two bodies of a contact, as indices of moving bodies: 0 is the tool, then come the "
                            "others in the order of the graph file.")
          .field("body", "1", &ContactPair::body,
                 "Index of the moving body: T of the contact. Of two that move it is the first.")
          .field("other", "1", &ContactPair::other, "Index of the other body where it moves too; -1 where it is fixed.")
          .type();
  return type;
}

template <>
const MessageType& message_type<ContactSet>() {
  static const MessageType type =
      Describe<ContactSet>("ContactSet", "W",
                           "The contacts of one query: those that penetrate, and those nearer than its margin. Stamped "
                           "valid for the time at which the query began; `bodies` may be older.")
          .field("bodies", &ContactSet::bodies,
                 "Moving bodies where the query took them to be. Only `count` and `X_WB` are set.")
          .field("count", "1", &ContactSet::count, "Entries of `contact` and `pair` in use.")
          .field("penetrating", "1", &ContactSet::penetrating, "Entries whose distance is below zero.")
          .field("truncated", "1", &ContactSet::truncated,
                 "Contacts that were found and left out because the set was full.")
          .field("contact", &ContactSet::contact, "Contacts of the bodies at the same index of `pair`.")
          .field("pair", &ContactSet::pair)
          .type();
  return type;
}

template <>
const MessageType& message_type<Forecast>() {
  static const MessageType type =
      Describe<Forecast>("Forecast", "W",
                         "A physics force on the device, and those expected at the next physics samples. Stamped valid "
                         "for the newest usable physics force.")
          .flat({{"current_force", "Physics force on the device at the stamp."},
                 {"current_torque", "Physics torque on the device at the stamp, about the origin of the handle D."}},
                &Forecast::current_D_W)
          .field("predicted", &Forecast::predicted_D_W,
                 "Wrenches on the device. `predicted[i - 1]` is expected at the stamp plus i times `horizon`, for i "
                 "from 1 to `count`.")
          .field("horizon", "s", &Forecast::horizon,
                 "Time from one predicted wrench to the next, above zero: the estimated period of physics.")
          .field("count", "1", &Forecast::count, "Entries of `predicted` in use, from 1 to 4.")
          .field("fallback", "1", &Forecast::fallback,
                 "1: the wrenches could not all be predicted, and some are held. 0: all are predicted.")
          .type();
  return type;
}

template <>
const MessageType& message_type<ForceSegment>() {
  static const MessageType type =
      Describe<ForceSegment>("ForceSegment", "W",
                             "A wrench on the device as a quintic in time: F(t) = c[0] + c[1] s + ... + c[5] s^5, with "
                             "s = (t - begin) / (end - begin). Before `begin` it is F(begin), after `end` F(end). "
                             "Stamped valid for the newest device sample that it was made from. So a pipeline that "
                             "repeats its last result is seen to be stale.")
          .field("begin", &ForceSegment::begin, "Time of the run at which s is 0.")
          .field("end", &ForceSegment::end, "Time of the run at which s is 1.")
          .field("c", &ForceSegment::c, "Coefficients of s to the powers 0 to 5.")
          .field("trust_time", &ForceSegment::trust_time,
                 "Age of that device sample from which the pipeline no longer vouches for the force; zero or less: not "
                 "given. It can only shorten the time that a device allows.")
          .type();
  return type;
}

template <>
const MessageType& message_type<SafetyState>() {
  using S = SafetyState;
  using enum SafetyCause;
  static const MessageType type =
      Describe<S>("SafetyState", "W", "The safety gate of a device at one tick. Stamped valid for that tick.")
          .choice("engagement", &S::engagement,
                  {{"disengaged", Engagement::disengaged, "Zero is commanded."},
                   {"ramping", Engagement::ramping,
                    "The wrench comes in (the cause is `none`) or goes out (the cause says why)."},
                   {"engaged", Engagement::engaged, "The pipeline's wrench is commanded, within the limits."},
                   {"fault", Engagement::fault,
                    "A brake or zero is commanded until the inputs have been healthy for a while."}},
                  "How far the gate lets the pipeline's wrench through.")
          .choice("cause", &S::cause,
                  {{"none", none, "Nothing keeps it out."},
                   {"not_finite", not_finite, "Fault: the pipeline's wrench was NaN or infinite."},
                   {"overspeed", overspeed, "Fault after a brake: the device moved faster than its limit."},
                   {"read_failed", read_failed,
                    "Fault: the device could not be read, or showed a state that is not finite."},
                   {"write_failed", write_failed, "Fault: the device did not take its wrench."},
                   {"time_reversed", time_reversed, "Fault: a tick was earlier than the one before."},
                   {"dead_man", dead_man, "The dead-man button was released."},
                   {"stale", stale, "No fresh segment has come for too long."},
                   {"not_permitted", not_permitted, "The run is starting or stopping."},
                   {"no_segment", no_segment, "No segment has come yet."},
                   {"device_not_ready", device_not_ready, "The device has shown no state yet."},
                   {"time_gap", time_gap,
                    "A tick came at the time of the one before, or long after it. It is counted and changes nothing."},
                   {"outside_workspace", outside_workspace, "The handle is beyond the end of the device's workspace."},
                   {"expired", expired,
                    "The line let go of a command that was not renewed in time. The force comes back by the slew "
                    "limit."}},
                  "Reason for which the wrench is kept out or ramps out.")
          .field("gain", "1", &S::gain, "Factor of the ramp, from 0 to 1.")
          .flat({{"clamped_force",
                  "Force on the device that the pipeline wants, within the limits of the gate, before "
                  "ramp and slew limit."},
                 {"clamped_torque", "Torque of the same, about the origin of the handle D."}},
                &S::clamped_D_W)
          .type();
  return type;
}

}  // namespace tactor
