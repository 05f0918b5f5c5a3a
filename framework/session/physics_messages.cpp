#include "framework/session/physics_messages.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

constexpr double unit_tolerance = 1e-3;
constexpr double point_tolerance = 1e-6;  // m, and as a share of the lengths around

[[noreturn]] void refuse_field(const std::string& field, const std::string& what) {
  throw ResultError(field, "expected " + what);
}

void check_finite(const std::string& field, const Vec3& v) {
  if (is_finite(v)) return;
  refuse_field(field, "finite numbers, found " + number_text(v.x) + ", " + number_text(v.y) + ", " + number_text(v.z));
}

void check_finite(const std::string& field, const Wrench& w) {
  check_finite(field + ".force", w.force);
  check_finite(field + ".torque", w.torque);
}

void check_length(const std::string& field, const std::string& what, double length) {
  if (std::abs(length - 1) <= unit_tolerance) return;
  refuse_field(field, what + " of length 1, found length " + number_text(length));
}

/// With its quaternion normalised. `frame`: `T` of the tool, `B` of any body.
Pose checked_pose(const std::string& body, const std::string& frame, const Pose& X) {
  check_finite(body + ".p_W" + frame, X.p);
  check_length(body + ".R_W" + frame, "a quaternion w, x, y, z",
               std::sqrt(X.R.w * X.R.w + X.R.x * X.R.x + X.R.y * X.R.y + X.R.z * X.R.z));
  return {X.p, normalized(X.R)};
}

void check_twist(const std::string& body, const std::string& frame, const Twist& V) {
  check_finite(body + ".v_W" + frame, V.v);
  check_finite(body + ".w_W" + frame, V.w);
}

/// All numbers of the contact, whichever its fields are.
void check_finite(const std::string& name, const Contact& contact) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&contact);
  for (const Field& field : message_type<Contact>().fields) {
    for (std::size_t i = 0; field.kind == FieldKind::f64 && i < count_of(field); ++i) {
      double value = 0;
      std::memcpy(&value, bytes + field.offset + i * sizeof value, sizeof value);
      if (!std::isfinite(value)) refuse_field(name + "." + field.name, "finite numbers, found " + number_text(value));
    }
  }
}

Contact checked_contact(const std::string& name, Contact contact) {
  check_finite(name, contact);
  const double length = norm(contact.n_W);
  check_length(name + ".n_W", "a normal", length);
  contact.n_W = contact.n_W / length;
  for (const auto& [field, value] : {std::pair{".weight", contact.weight}, {".stiffness", contact.stiffness}}) {
    if (!(value > 0)) refuse_field(name + field, "a number above 0, found " + number_text(value));
  }
  for (const auto& [field, value] : {std::pair{".damping", contact.damping},
                                     {".friction", contact.friction},
                                     {".inertia", contact.inertia},
                                     {".creep", contact.creep}}) {
    if (value < 0) refuse_field(name + field, "0 or more, found " + number_text(value));
  }
  if (contact.lift < 0 || contact.lift > 1) {
    refuse_field(name + ".lift", "0 to 1, found " + number_text(contact.lift));
  }
  return contact;
}

/// m, in the body's frame: the point of the moving body of a contact, at its distance from the other one along the
/// normal.
Vec3 own_point(const Contact& contact, const Pose& X_WB) {
  return rotate(inverse(X_WB.R), contact.p_WC + contact.distance * contact.n_W - X_WB.p);
}

void check_own_point(const std::string& name, const Contact& contact, const Pose& X_WB) {
  const Vec3 expected = own_point(contact, X_WB);
  const double scale = 1 + std::max({norm(contact.p_TC), norm(contact.p_WC), norm(X_WB.p)});
  if (norm(contact.p_TC - expected) <= point_tolerance * scale) return;
  refuse_field(name + ".p_TC", "the point at `distance` along `n_W` from `p_WC`, which is " + number_text(expected.x) +
                                   ", " + number_text(expected.y) + ", " + number_text(expected.z) +
                                   " m in the body's frame, or none, found " + number_text(contact.p_TC.x) + ", " +
                                   number_text(contact.p_TC.y) + ", " + number_text(contact.p_TC.z));
}

void check_pair(const std::string& name, const ContactPair& pair, int moving) {
  if (pair.body < 0 || pair.body >= moving) {
    refuse_field(name + ".body",
                 "a moving body, 0 to " + std::to_string(moving - 1) + ", found " + std::to_string(pair.body));
  }
  if (pair.other < ContactPair::fixed || pair.other >= moving || pair.other == pair.body) {
    refuse_field(name + ".other", "another moving body, below " + std::to_string(moving) +
                                      ", or -1 for one that does not move, found " + std::to_string(pair.other));
  }
}

ContactSet checked_contacts(const PhysicsResult& result, const BodyStates& bodies) {
  ContactSet set = *result.contacts;
  if (set.count < 0 || set.count > ContactSet::capacity) {
    refuse_field("contacts",
                 "at most " + std::to_string(ContactSet::capacity) + " of them, found " + std::to_string(set.count));
  }
  set.bodies = bodies;
  set.bodies.V_WB = {};
  set.penetrating = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const std::string name = "contacts[" + std::to_string(i) + "]";
    if (result.without_p_TC[i]) set.contact[i].p_TC = {};
    Contact& contact = set.contact[i] = checked_contact(name, set.contact[i]);
    check_pair(name, set.pair[i], bodies.count);
    const Pose& X_WB = bodies.X_WB[static_cast<std::size_t>(set.pair[i].body)];
    if (result.without_p_TC[i]) {
      contact.p_TC = own_point(contact, X_WB);
    } else {
      check_own_point(name, contact, X_WB);
    }
    if (contact.distance < 0) ++set.penetrating;
  }
  return set;
}

/// Refuses a body that turns and whose rotation is not told.
void check_rotation(const std::string& body, const std::string& frame, bool is_told, Motion motion) {
  if (is_told || motion != Motion::rigid) return;
  refuse_field(body + ".R_W" + frame, "a rotation, because the body turns (`motion: rigid`), found none");
}

bool same_twist(const Twist& a, const Twist& b) {
  return a.v == b.v && a.w == b.w;
}

/// None where the result has no tool.
std::optional<BodyStates> checked_bodies(const PhysicsResult& result, std::span<const Motion> moving) {
  const auto count = result.bodies != nullptr ? result.bodies->count : result.X_WT ? 1 : 0;
  if (count == 0 && result.bodies == nullptr) return std::nullopt;
  if (moving.empty()) refuse_field(result.bodies != nullptr ? "bodies" : "tool", "none, because no body moves");
  if (count != static_cast<std::int64_t>(moving.size())) {
    refuse_field(result.bodies != nullptr ? "bodies" : "tool", "all moving bodies of the scene, which are " +
                                                                   std::to_string(moving.size()) + ", found " +
                                                                   std::to_string(count));
  }
  BodyStates bodies{.count = 1, .massless = 0, .X_WB = {}, .V_WB = {}};
  if (result.bodies != nullptr) bodies = *result.bodies;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count) && result.bodies != nullptr; ++i) {
    const std::string name = "bodies[" + std::to_string(i) + "]";
    check_rotation(name, "B", !result.without_rotation[i], moving[i]);
    bodies.X_WB[i] = checked_pose(name, "B", bodies.X_WB[i]);
    check_twist(name, "B", bodies.V_WB[i]);
  }
  if (result.X_WT) {
    if (result.bodies != nullptr &&
        !(result.bodies->X_WB[0] == *result.X_WT && same_twist(result.bodies->V_WB[0], result.V_WT))) {
      refuse_field("bodies[0]", "the pose and velocity of `tool`, or no `tool`");
    }
    check_rotation("tool", "T", !result.without_rotation[0], moving[0]);
    bodies.X_WB[0] = checked_pose("tool", "T", *result.X_WT);
    check_twist("tool", "T", result.V_WT);
    bodies.V_WB[0] = result.V_WT;
  }
  return bodies;
}

}  // namespace

PhysicsMessages physics_messages(const PhysicsResult& result, Time valid, const DeviceState& handle,
                                 std::span<const Motion> moving) {
  PhysicsMessages messages{.valid = valid,
                           .state = {},
                           .bodies = checked_bodies(result, moving),
                           .contacts = {},
                           .force = result.felt_D_W,
                           .engine = {}};
  if (result.felt_D_W) check_finite("felt", *result.felt_D_W);
  if (result.contact_T_W) check_finite("contact", *result.contact_T_W);
  if (!messages.bodies) {
    if (result.contacts != nullptr || result.contact_T_W) refuse_field("tool", "a pose, because contacts are told");
    if (!result.copy_state.empty()) refuse_field("tool", "a pose, because a state of the light copy is told");
    if (!result.felt_D_W) refuse_field("tool", "a pose, or a wrench as `felt`, found neither");
    return messages;
  }
  if (result.contacts != nullptr) messages.contacts = checked_contacts(result, *messages.bodies);
  const Wrench contact = result.contact_T_W.value_or(Wrench{});
  const bool touches = norm(contact.force) > 0 || norm(contact.torque) > 0;
  messages.state = PhysicsState{.X_WT = messages.bodies->X_WB[0],
                                .V_WT = messages.bodies->V_WB[0],
                                .X_WD = handle.X_WD,
                                .V_WD = handle.V_WD,
                                .contact_T_W = contact,
                                .contacts = messages.contacts ? messages.contacts->penetrating
                                            : touches         ? 1
                                                              : 0,
                                .damped = result.contact_T_W ? 0 : 1};
  return messages;
}

}  // namespace tactor
