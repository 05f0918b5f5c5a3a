#include "framework/core/messages.hpp"

#include <cstddef>

namespace tactor {

namespace {

using enum FieldKind;

void add_vec3(std::vector<Field>& fields, std::string_view name, std::string_view unit, std::size_t offset) {
  fields.push_back({name, unit, f64, offset, 3});
}

void add_pose(std::vector<Field>& fields, std::string_view p, std::string_view R, std::size_t offset) {
  add_vec3(fields, p, "m", offset + offsetof(Pose, p));
  fields.push_back({R, "1", f64, offset + offsetof(Pose, R), 4});
}

void add_twist(std::vector<Field>& fields, std::string_view v, std::string_view w, std::size_t offset) {
  add_vec3(fields, v, "m/s", offset + offsetof(Twist, v));
  add_vec3(fields, w, "rad/s", offset + offsetof(Twist, w));
}

static_assert(sizeof(Wrench) == 6 * sizeof(double));
void add_wrench(std::vector<Field>& fields, std::string_view force, std::string_view torque, std::size_t offset) {
  add_vec3(fields, force, "N", offset + offsetof(Wrench, force));
  add_vec3(fields, torque, "N m", offset + offsetof(Wrench, torque));
}

template <class T, class Build>
MessageType describe(std::string_view name, std::string_view frame, Build build) {
  static_assert(Message<T>);
  MessageType type{name, frame, sizeof(T), alignof(T), {}};
  build(type.fields);
  return type;
}

}  // namespace

template <>
const MessageType& message_type<Wrench>() {
  static const MessageType type = describe<Wrench>("Wrench", "W", [](auto& f) { add_wrench(f, "force", "torque", 0); });
  return type;
}

template <>
const MessageType& message_type<Target>() {
  static const MessageType type = describe<Target>("Target", "W", [](auto& f) {
    add_pose(f, "p_WH", "R_WH", offsetof(Target, X_WH));
    add_twist(f, "v_WH", "w_WH", offsetof(Target, V_WH));
  });
  return type;
}

template <>
const MessageType& message_type<DeviceState>() {
  static const MessageType type = describe<DeviceState>("DeviceState", "W", [](auto& f) {
    add_pose(f, "p_WD", "R_WD", offsetof(DeviceState, X_WD));
    add_twist(f, "v_WD", "w_WD", offsetof(DeviceState, V_WD));
    f.push_back({"buttons", "1", i32, offsetof(DeviceState, buttons), 1});
  });
  return type;
}

namespace {
void add_coupling(std::vector<Field>& f, std::size_t offset) {
  f.push_back({"k_t", "N/m", f64, offset + offsetof(CouplingParameters, k_t), 1});
  f.push_back({"b_t", "N s/m", f64, offset + offsetof(CouplingParameters, b_t), 1});
  f.push_back({"k_r", "N m/rad", f64, offset + offsetof(CouplingParameters, k_r), 1});
  f.push_back({"b_r", "N m s/rad", f64, offset + offsetof(CouplingParameters, b_r), 1});
  f.push_back({"force_max", "N", f64, offset + offsetof(CouplingParameters, force_max), 1});
  f.push_back({"torque_max", "N m", f64, offset + offsetof(CouplingParameters, torque_max), 1});
  f.push_back({"massless", "1", i32, offset + offsetof(CouplingParameters, massless), 1});
}
}  // namespace

template <>
const MessageType& message_type<CouplingParameters>() {
  static const MessageType type =
      describe<CouplingParameters>("CouplingParameters", "", [](auto& f) { add_coupling(f, 0); });
  return type;
}

template <>
const MessageType& message_type<PhysicsState>() {
  static const MessageType type = describe<PhysicsState>("PhysicsState", "W", [](auto& f) {
    add_pose(f, "p_WT", "R_WT", offsetof(PhysicsState, X_WT));
    add_twist(f, "v_WT", "w_WT", offsetof(PhysicsState, V_WT));
    add_pose(f, "p_WD", "R_WD", offsetof(PhysicsState, X_WD));
    add_twist(f, "v_WD", "w_WD", offsetof(PhysicsState, V_WD));
    add_wrench(f, "contact_force", "contact_torque", offsetof(PhysicsState, contact_T_W));
    f.push_back({"contacts", "1", i32, offsetof(PhysicsState, contacts), 1});
    f.push_back({"damped", "1", i32, offsetof(PhysicsState, damped), 1});
  });
  return type;
}

namespace {
void add_bodies(std::vector<Field>& f, std::string_view count, std::string_view poses, std::string_view twists,
                std::size_t offset) {
  // A pose is 7 numbers in a row: p, then R as w, x, y, z. A twist is 6: v, w.
  static_assert(sizeof(Pose) == 7 * sizeof(double) && sizeof(Twist) == 6 * sizeof(double));
  f.push_back({count, "1", i32, offset + offsetof(BodyStates, count), 1});
  f.push_back({poses, "m, 1", f64, offset + offsetof(BodyStates, X_WB), 7 * BodyStates::capacity});
  f.push_back({twists, "m/s, rad/s", f64, offset + offsetof(BodyStates, V_WB), 6 * BodyStates::capacity});
}
}  // namespace

template <>
const MessageType& message_type<BodyStates>() {
  static const MessageType type = describe<BodyStates>("BodyStates", "W", [](auto& f) {
    add_bodies(f, "count", "X_WB", "V_WB", 0);
    f.insert(f.begin() + 1, {"massless", "1", i32, offsetof(BodyStates, massless), 1});
  });
  return type;
}

template <>
const MessageType& message_type<ContactSet>() {
  static const MessageType type = describe<ContactSet>("ContactSet", "W", [](auto& f) {
    add_bodies(f, "bodies", "X_WB", "V_WB", offsetof(ContactSet, bodies));
    f.push_back({"count", "1", i32, offsetof(ContactSet, count), 1});
    f.push_back({"penetrating", "1", i32, offsetof(ContactSet, penetrating), 1});
    f.push_back({"truncated", "1", i32, offsetof(ContactSet, truncated), 1});
    // A contact is 20 numbers in a row: p_TC, p_WC, n_W, distance, weight, stiffness, damping, friction, H_W.
    static_assert(sizeof(Contact) == 20 * sizeof(double));
    f.push_back({"contact", "m, m, 1, m, 1, N/m, N s/m, 1, 1/m", f64, offsetof(ContactSet, contact),
                 20 * ContactSet::capacity});
    f.push_back({"pair", "1", i32, offsetof(ContactSet, pair), 2 * ContactSet::capacity});
  });
  return type;
}

namespace {
void add_local_contacts(std::vector<Field>& f, std::size_t offset) {
  using L = LocalContacts;
  f.push_back({"anchors", "1", i32, offset + offsetof(L, anchors), 1});
  f.push_back({"moving", "1", i32, offset + offsetof(L, bodies), 1});
  f.push_back({"count", "1", i32, offset + offsetof(L, count), 1});
  f.push_back({"X_WB_anchor", "m, 1", f64, offset + offsetof(L, X_WB), 7 * BodyStates::capacity * L::max_anchors});
  f.push_back({"contact", "m, m, 1, m, 1, N/m, N s/m, 1, 1/m", f64, offset + offsetof(L, contact),
               20 * L::max_anchors * L::capacity});
  f.push_back({"pair", "1", i32, offset + offsetof(L, pair), 2 * L::capacity});
}
}  // namespace

template <>
const MessageType& message_type<LocalContacts>() {
  static const MessageType type =
      describe<LocalContacts>("LocalContacts", "W", [](auto& f) { add_local_contacts(f, 0); });
  return type;
}

template <>
const MessageType& message_type<LocalModel>() {
  static const MessageType type = describe<LocalModel>("LocalModel", "W", [](auto& f) {
    f.push_back({"time", "ns", i64, offsetof(LocalModel, time), 1});
    add_pose(f, "p_WD", "R_WD", offsetof(LocalModel, device) + offsetof(DeviceState, X_WD));
    add_twist(f, "v_WD", "w_WD", offsetof(LocalModel, device) + offsetof(DeviceState, V_WD));
    add_bodies(f, "bodies", "X_WB", "V_WB", offsetof(LocalModel, bodies));
    add_coupling(f, offsetof(LocalModel, coupling));
    add_local_contacts(f, offsetof(LocalModel, contacts));
  });
  return type;
}

template <>
const MessageType& message_type<ArCoefficients>() {
  static const MessageType type = describe<ArCoefficients>("ArCoefficients", "", [](auto& f) {
    f.push_back({"force_order", "1", i32, offsetof(ArCoefficients, force_order), 1});
    f.push_back({"torque_order", "1", i32, offsetof(ArCoefficients, torque_order), 1});
    f.push_back({"detrend", "1", i32, offsetof(ArCoefficients, detrend), 1});
    f.push_back({"window", "1", i32, offsetof(ArCoefficients, window), 1});
    f.push_back({"model_structure", "1", i32, offsetof(ArCoefficients, model_structure), 1});
    f.push_back({"grid_period", "s", f64, offsetof(ArCoefficients, grid_period), 1});
    f.push_back({"force", "1", f64, offsetof(ArCoefficients, force), ArCoefficients::capacity});
    f.push_back({"torque", "1", f64, offsetof(ArCoefficients, torque), ArCoefficients::capacity});
    f.push_back({"force_error_variance", "N^2", f64, offsetof(ArCoefficients, force_error_variance), 1});
    f.push_back({"torque_error_variance", "N^2 m^2", f64, offsetof(ArCoefficients, torque_error_variance), 1});
  });
  return type;
}

template <>
const MessageType& message_type<Forecast>() {
  static const MessageType type = describe<Forecast>("Forecast", "W", [](auto& f) {
    add_wrench(f, "current_force", "current_torque", offsetof(Forecast, current_D_W));
    // Wrenches in a row, force then torque, one for each step ahead.
    f.push_back({"predicted", "N, N m", f64, offsetof(Forecast, predicted_D_W), 6 * Forecast::capacity});
    f.push_back({"horizon", "s", f64, offsetof(Forecast, horizon), 1});
    f.push_back({"count", "1", i32, offsetof(Forecast, count), 1});
    f.push_back({"fallback", "1", i32, offsetof(Forecast, fallback), 1});
  });
  return type;
}

template <>
const MessageType& message_type<ForceSegment>() {
  static const MessageType type = describe<ForceSegment>("ForceSegment", "W", [](auto& f) {
    f.push_back({"begin", "ns", i64, offsetof(ForceSegment, begin), 1});
    f.push_back({"end", "ns", i64, offsetof(ForceSegment, end), 1});
    // Six wrenches in a row, force then torque, from the constant to the quintic term.
    f.push_back({"c", "N, N m", f64, offsetof(ForceSegment, c), 36});
  });
  return type;
}

template <>
const MessageType& message_type<SafetyState>() {
  static const MessageType type = describe<SafetyState>("SafetyState", "W", [](auto& f) {
    f.push_back({"engagement", "1", i32, offsetof(SafetyState, engagement), 1});
    f.push_back({"cause", "1", i32, offsetof(SafetyState, cause), 1});
    f.push_back({"gain", "1", f64, offsetof(SafetyState, gain), 1});
    add_wrench(f, "clamped_force", "clamped_torque", offsetof(SafetyState, clamped_D_W));
  });
  return type;
}

const MessageType* find_message_type(std::string_view name) {
  for (const MessageType* type :
       {&message_type<Wrench>(), &message_type<Target>(), &message_type<DeviceState>(),
        &message_type<CouplingParameters>(), &message_type<PhysicsState>(), &message_type<BodyStates>(),
        &message_type<ContactSet>(), &message_type<LocalContacts>(), &message_type<LocalModel>(),
        &message_type<ArCoefficients>(), &message_type<Forecast>(), &message_type<ForceSegment>(),
        &message_type<SafetyState>()}) {
    if (type->name == name) return type;
  }
  return nullptr;
}

}  // namespace tactor
