// The messages between the bridge and its client, whatever they are written as. Frames: W world, D handle, T tool, B
// body.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "framework/core/messages.hpp"

namespace tactor {

/// The version of the protocol, in `hello`.
inline constexpr int bridge_protocol = 1;

/// A step that the client is to compute: see PhysicsStep.
struct BridgeStep {
  std::uint64_t id = 0;  ///< counts the steps of the run, from 1
  Time begin, end;
  DeviceState from, handle;
  CouplingParameters coupling;
};

/// A contact and who touches whom, as indices into the moving bodies.
struct BridgeContact {
  Contact contact{.weight = 1};
  ContactPair pair;
  std::optional<bool> has_p_TC;  ///< empty: it has not
};

struct BridgeTool {
  Pose X_WT;                         ///< m
  Twist V_WT;                        ///< m/s, rad/s
  std::optional<bool> has_rotation;  ///< R_WT and w_WT; empty: it has not
};

struct BridgeBody {
  Pose X_WB;                         ///< m
  Twist V_WB;                        ///< m/s, rad/s
  std::optional<bool> has_rotation;  ///< R_WB and w_WB; empty: it has not
};

/// The result of a step: see PhysicsResult. What is not given is empty.
struct BridgeResult {
  std::uint64_t id = 0;      ///< of the step
  std::optional<Time> time;  ///< that it holds for; empty: the end of the step
  std::optional<BridgeTool> tool;
  std::optional<Wrench> felt;                          ///< N, N m, on the device, in W
  std::optional<Wrench> contact;                       ///< N, N m, on the tool about its origin, in W
  std::optional<std::vector<BridgeContact>> contacts;  ///< at most ContactSet::capacity
  std::optional<std::vector<BridgeBody>> bodies;       ///< at most BodyStates::capacity, the tool first
};

/// The client asks for the newest step, and gives no result for the open one.
struct BridgeNext {};

/// A frame of the client was refused.
struct BridgeError {
  std::string message;
  std::string field;  ///< of the message that was refused: `contacts[3].n_W`; empty: all of it
};

/// Refuses what a client has sent.
class BridgeRefusal : public std::runtime_error {
 public:
  BridgeRefusal(std::string field, const std::string& message)
      : std::runtime_error(message), field_(std::move(field)) {}
  [[nodiscard]] const std::string& field() const { return field_; }

 private:
  std::string field_;
};

/// A message as it is sent: a text of JSON, or packed bytes.
struct BridgeFrame {
  std::string bytes;
  bool packed = false;
};

/// The place of a value in a message, as a chain of names.
struct BridgePath {
  const BridgePath* parent = nullptr;
  const char* name = "";
  std::ptrdiff_t index = -1;  ///< of an element of the list `name`; -1: no element

  [[nodiscard]] std::string text() const {
    std::string text = parent == nullptr || parent->parent == nullptr ? name : parent->text() + "." + name;
    if (index >= 0) text += "[" + std::to_string(index) + "]";
    return text;
  }
};

/// Numbers and fixed lists of them.
template <class T>
concept IsPlain = std::is_arithmetic_v<T> || std::same_as<T, Time> || std::same_as<T, Vec3> || std::same_as<T, Quat> ||
    std::same_as<T, std::array<double, 6>>;

template <class T, class Record>
concept IsRecord = std::same_as<std::remove_const_t<T>, Record>;

// The fields of each record, in the order of the packed bytes, by the names that messages have. `v(name, member)` takes
// a field, and `v.or_default(name, member)` one that a text may leave out. `v.if_told(has, name, member)` takes one
// that a message may leave out, and says in `has` whether it has it; of the fields with the same `has` a message has
// all or none.
void fields(auto& v, IsRecord<Wrench> auto& F) {
  v("force", F.force);
  v("torque", F.torque);
}
void fields(auto& v, IsRecord<DeviceState> auto& state) {
  v("p_WD", state.X_WD.p);
  v("R_WD", state.X_WD.R);
  v("v_WD", state.V_WD.v);
  v("w_WD", state.V_WD.w);
  v("buttons", state.buttons);
}
void fields(auto& v, IsRecord<CouplingParameters> auto& c) {
  v("k_t", c.k_t);
  v("b_t", c.b_t);
  v("k_r", c.k_r);
  v("b_r", c.b_r);
  v("force_max", c.force_max);
  v("torque_max", c.torque_max);
  v("massless", c.massless);
}
void fields(auto& v, IsRecord<BridgeStep> auto& step) {
  v("id", step.id);
  v("begin", step.begin);
  v("end", step.end);
  v("from", step.from);
  v("handle", step.handle);
  v("coupling", step.coupling);
}
void fields(auto& v, IsRecord<BridgeContact> auto& c) {
  v.if_told(c.has_p_TC, "p_TC", c.contact.p_TC);
  v("p_WC", c.contact.p_WC);
  v("n_W", c.contact.n_W);
  v("distance", c.contact.distance);
  v.or_default("weight", c.contact.weight);
  v("stiffness", c.contact.stiffness);
  v("damping", c.contact.damping);
  v("friction", c.contact.friction);
  v.or_default("inertia", c.contact.inertia);
  v.or_default("creep", c.contact.creep);
  v.or_default("lift", c.contact.lift);
  v.or_default("H_W", c.contact.H_W);
  v.or_default("body", c.pair.body);
  v.or_default("other", c.pair.other);
}
void fields(auto& v, IsRecord<BridgeTool> auto& tool) {
  v("p_WT", tool.X_WT.p);
  v.if_told(tool.has_rotation, "R_WT", tool.X_WT.R);
  v("v_WT", tool.V_WT.v);
  v.if_told(tool.has_rotation, "w_WT", tool.V_WT.w);
}
void fields(auto& v, IsRecord<BridgeBody> auto& body) {
  v("p_WB", body.X_WB.p);
  v.if_told(body.has_rotation, "R_WB", body.X_WB.R);
  v("v_WB", body.V_WB.v);
  v.if_told(body.has_rotation, "w_WB", body.V_WB.w);
}
void fields(auto& v, IsRecord<BridgeResult> auto& result) {
  v("id", result.id);
  v("time", result.time);
  v("tool", result.tool);
  v("felt", result.felt);
  v("contact", result.contact);
  v("contacts", result.contacts);
  v("bodies", result.bodies);
}

/// The most elements of each list.
constexpr std::size_t most_of(const std::vector<BridgeContact>&) {
  return ContactSet::capacity;
}
constexpr std::size_t most_of(const std::vector<BridgeBody>&) {
  return BodyStates::capacity;
}

}  // namespace tactor
