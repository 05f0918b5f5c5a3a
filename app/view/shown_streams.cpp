#include "app/view/shown_streams.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <new>
#include <set>

#include "framework/core/body_poses.hpp"
#include "framework/core/messages.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mesh/deformed_surfaces.hpp"

namespace tactor {

namespace {

/// Poses are drawn, not plotted.
constexpr Duration pose_gap{8'000'000};
/// Surfaces have a thousand times as many numbers.
constexpr Duration surface_gap{33'000'000};

template <class T>
T as(const void* value) {
  T message;
  std::memcpy(static_cast<void*>(&message), value, sizeof message);
  return message;
}

template <class... Values>
void put(ShownRows& rows, Values... values) {
  (rows.values.push_back(static_cast<float>(values)), ...);
}

void put_vector(ShownRows& rows, const Vec3& v) {
  put(rows, v.x, v.y, v.z);
}

void put_pose(ShownRows& rows, Time t, const Pose& X) {
  rows.times.push_back(t.seconds());
  put_vector(rows, X.p);
  put(rows, X.R.w, X.R.x, X.R.y, X.R.z);
}

void put_wrench(ShownRows& rows, Time t, const Wrench& wrench, bool torque) {
  rows.times.push_back(t.seconds());
  put_vector(rows, wrench.force);
  if (torque) put_vector(rows, wrench.torque);
}

std::vector<ShownColumn> wrench_columns(bool torque) {
  std::vector<ShownColumn> columns{{"force.x", "N"}, {"force.y", "N"}, {"force.z", "N"}};
  if (torque) columns.insert(columns.end(), {{"torque.x", "N m"}, {"torque.y", "N m"}, {"torque.z", "N m"}});
  return columns;
}

const std::vector<ShownColumn> pose_columns{{"p.x", "m"}, {"p.y", "m"}, {"p.z", "m"}, {"R.w", "1"},
                                            {"R.x", "1"}, {"R.y", "1"}, {"R.z", "1"}};
const std::vector<ShownColumn> point_columns{{"p.x", "m"}, {"p.y", "m"}, {"p.z", "m"},
                                             {"n.x", "1"}, {"n.y", "1"}, {"n.z", "1"}};

ShownStream wrench_stream(std::string role, std::string output, bool torque, bool on_arrival) {
  return {.role = std::move(role),
          .output = std::move(output),
          .columns = wrench_columns(torque),
          .add = [torque, on_arrival](const Stamp& stamp, const void* value, ShownRows& rows) {
            put_wrench(rows, on_arrival ? stamp.produced : stamp.valid, as<Wrench>(value), torque);
          }};
}

ShownStream forecast_stream(std::string output, bool torque) {
  return {.role = "predicted",
          .output = std::move(output),
          .columns = wrench_columns(torque),
          .add = [torque](const Stamp& stamp, const void* value, ShownRows& rows) {
            const auto forecast = as<Forecast>(value);
            if (forecast.count < 1) return;
            // What is expected one physics period after the sample, at the time for which it is expected.
            put_wrench(rows, stamp.valid + Duration::from_seconds(forecast.horizon), forecast.predicted_D_W[0], torque);
          }};
}

ShownStream handle_stream(std::string output) {
  return {.role = "handle",
          .output = std::move(output),
          .columns = pose_columns,
          .least_gap = pose_gap,
          .add = [](const Stamp& stamp, const void* value, ShownRows& rows) {
            put_pose(rows, stamp.valid, as<DeviceState>(value).X_WD);
          }};
}

ShownStream safety_stream(std::string output) {
  return {.role = "safety",
          .output = std::move(output),
          .columns = {{"engagement", "1"}, {"cause", "1"}, {"gain", "1"}},
          .least_gap = pose_gap,
          .add = [](const Stamp& stamp, const void* value, ShownRows& rows) {
            const auto safety = as<SafetyState>(value);
            rows.times.push_back(stamp.valid.seconds());
            put(rows, static_cast<int>(safety.engagement), static_cast<int>(safety.cause), safety.gain);
          }};
}

/// `moving`: its index into Scene::moving().
ShownStream body_stream(std::string output, std::size_t moving, std::size_t body) {
  return {.role = "body",
          .output = std::move(output),
          .columns = pose_columns,
          .body = body,
          .least_gap = pose_gap,
          .add = [moving](const Stamp& stamp, const void* value, ShownRows& rows) {
            const auto bodies = as<BodyStates>(value);
            if (moving < static_cast<std::size_t>(bodies.count)) put_pose(rows, stamp.produced, bodies.X_WB[moving]);
          }};
}

/// A shape that a node brings.
ShownStream shape_stream(std::string output, const DrawnScene::Moved& moved, std::size_t body) {
  return {.role = "body",
          .output = std::move(output),
          .columns = pose_columns,
          .shares_arrays = true,
          .body = body,
          .least_gap = pose_gap,
          .add = [pose = moved.pose, X_BS = moved.X_BS](const Stamp& stamp, const void* value, ShownRows& rows) {
            // The bytes of the message, which is not ours to copy or to end.
            alignas(BodyPoses) std::array<std::byte, sizeof(BodyPoses)> bytes{};
            std::memcpy(bytes.data(), value, sizeof bytes);
            const auto& told = *std::launder(reinterpret_cast<const BodyPoses*>(bytes.data()));
            if (pose < told.poses.size()) put_pose(rows, stamp.produced, pose_of(told.poses[pose]) * X_BS);
          }};
}

ShownStream tool_stream(std::string output, std::size_t body) {
  return {.role = "body",
          .output = std::move(output),
          .columns = pose_columns,
          .body = body,
          .least_gap = pose_gap,
          .add = [](const Stamp& stamp, const void* value, ShownRows& rows) {
            put_pose(rows, stamp.produced, as<PhysicsState>(value).X_WT);
          }};
}

ShownStream contact_count_stream(std::string output) {
  return {.role = "contact_count",
          .output = std::move(output),
          .columns = {{"contacts", "1"}},
          .add = [](const Stamp& stamp, const void* value, ShownRows& rows) {
            rows.times.push_back(stamp.produced.seconds());
            put(rows, as<PhysicsState>(value).contacts);
          }};
}

ShownStream delay_stream(std::string output) {
  return {.role = "delay",
          .output = std::move(output),
          .columns = {{"delay", "s"}},
          .add = [](const Stamp& stamp, const void*, ShownRows& rows) {
            rows.times.push_back(stamp.produced.seconds());
            put(rows, (stamp.produced - stamp.valid).seconds());
          }};
}

void begin_set(ShownRows& rows, Time t) {
  rows.times.assign(1, t.seconds());
  rows.values.clear();
}

ShownStream contacts_stream(std::string output) {
  std::vector<ShownColumn> columns = point_columns;
  columns.push_back({"distance", "m"});
  return {.role = "contacts",
          .output = std::move(output),
          .columns = std::move(columns),
          .is_set = true,
          .add = [](const Stamp& stamp, const void* value, ShownRows& rows) {
            const auto contacts = as<ContactSet>(value);
            begin_set(rows, stamp.produced);
            for (std::int32_t i = 0; i < std::min(contacts.count, ContactSet::capacity); ++i) {
              const Contact& contact = contacts.contact[static_cast<std::size_t>(i)];
              if (contact.distance > 0) continue;
              put_vector(rows, contact.p_WC);
              put_vector(rows, contact.n_W);
              put(rows, contact.distance);
            }
          }};
}

ShownStream patch_stream(std::string output) {
  return {.role = "patch",
          .output = std::move(output),
          .columns = point_columns,
          .is_set = true,
          .add = [](const Stamp& stamp, const void* value, ShownRows& rows) {
            const auto local = as<LocalContacts>(value);
            begin_set(rows, stamp.produced);
            for (std::int32_t i = 0; i < std::min(local.count, LocalContacts::capacity); ++i) {
              const Contact& contact = local.contact[static_cast<std::size_t>(i)][0];
              put_vector(rows, contact.p_WC);
              put_vector(rows, contact.n_W);
            }
          }};
}

/// The surfaces of the deformable bodies, whose array stays with the message.
ShownStream surface_stream(std::string output) {
  return {.role = "surface",
          .output = std::move(output),
          .columns = {{"p.x", "m"}, {"p.y", "m"}, {"p.z", "m"}},
          .is_set = true,
          .least_gap = surface_gap,
          .add = [](const Stamp& stamp, const void* value, ShownRows& rows) {
            // The bytes of the message, which is not ours to copy or to end.
            alignas(DeformedSurfaces) std::array<std::byte, sizeof(DeformedSurfaces)> bytes{};
            std::memcpy(bytes.data(), value, sizeof bytes);
            const auto& surfaces = *std::launder(reinterpret_cast<const DeformedSurfaces*>(bytes.data()));
            begin_set(rows, stamp.produced);
            for (const ShownPoint& point : surfaces.nodes) {
              rows.values.insert(rows.values.end(), point.p_W.begin(), point.p_W.end());
            }
          }};
}

/// What an experiment shows a participant, by the description of its message.
std::optional<ShownStream> experiment_stream(const std::string& name, const MessageType& type) {
  if (type.name != "experiment.Screen") return std::nullopt;
  ShownStream stream{.role = "experiment", .output = name};
  for (const Field& field : type.fields) stream.columns.push_back({field.name, field.unit});
  stream.add = [&type](const Stamp& stamp, const void* value, ShownRows& rows) {
    rows.times.push_back(stamp.valid.seconds());
    for (const Field& field : type.fields) {
      const auto* at = static_cast<const std::byte*>(value) + field.offset;
      put(rows, field.kind == FieldKind::f64 ? as<double>(at) : static_cast<double>(as<std::int32_t>(at)));
    }
  };
  return stream;
}

bool is(const OutputInfo& output, const MessageType& type) {
  return same_type(*output.type, type);
}

bool makes_force(const NodeSpec& node) {
  return node.info->role == Role::prediction || node.info->role == Role::interpolation;
}

/// The predictors and interpolators that make what arrives at the input, the nearest first.
std::vector<std::size_t> makers_of(const Plan& plan, std::size_t node, std::size_t input) {
  std::vector<std::size_t> found;
  const auto add = [&](std::size_t from) {
    if (makes_force(plan.nodes[from]) && std::find(found.begin(), found.end(), from) == found.end()) {
      found.push_back(from);
    }
  };
  for (const PlannedEdge& edge : plan.edges) {
    if (edge.to == node && edge.input == input) add(edge.from);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const PlannedEdge& edge : plan.edges) {
      if (edge.to == found[i]) add(edge.from);
    }
  }
  return found;
}

/// Of nodes from the nearest on: the name of the predictor, or of its type where it has the usual name of its stage.
std::string method_label(const Plan& plan, const std::vector<std::size_t>& nodes) {
  for (const Role role : {Role::prediction, Role::interpolation}) {
    for (const std::size_t n : nodes) {
      const NodeSpec& node = plan.nodes[n];
      if (node.info->role != role) continue;
      const std::string& type = node.info->type;
      return node.name == name_of(role) ? type.substr(type.find('.') + 1) : node.name;
    }
  }
  return plan.nodes[nodes.front()].name;
}

/// The bodies of the plan's scene that move, as they are drawn; none where a node draws them.
std::vector<std::optional<std::size_t>> drawn_bodies(const Plan& plan, const DrawnScene& drawn) {
  std::vector<std::optional<std::size_t>> found;
  for (const std::size_t i : plan.graph.scene.moving()) {
    const std::optional<std::size_t> at = drawn.index_of(plan.graph.scene.bodies[i].name);
    found.push_back(at && !drawn.moved[*at] ? at : std::nullopt);
  }
  return found;
}

void add_shapes_of(const std::string& node, const std::string& output, const DrawnScene& drawn,
                   std::vector<ShownStream>& streams) {
  for (std::size_t i = 0; i < drawn.moved.size(); ++i) {
    const auto& moved = drawn.moved[i];
    if (moved && moved->node == node) streams.push_back(shape_stream(output, *moved, i));
  }
}

void add_streams_of(const Plan& plan, const DrawnScene& drawn, std::size_t n, bool has_bodies,
                    std::vector<ShownStream>& streams) {
  const NodeSpec& node = plan.nodes[n];
  const std::vector<std::optional<std::size_t>> moving = drawn_bodies(plan, drawn);
  for (const OutputInfo& output : node.info->outputs) {
    const std::string name = node.name + "." + output.name;
    if (is(output, message_type<Wrench>())) {
      const Role role = node.info->role;
      if (role == Role::coupling || role == Role::force_field) {
        streams.push_back(wrench_stream("physics", name, plan.torque, true));
        streams.push_back(delay_stream(name));
      } else if (node.info->actuator && (output.name == "interpolated" || output.name == "commanded")) {
        streams.push_back(wrench_stream(output.name, name, plan.torque, false));
      }
    } else if (auto experiment = experiment_stream(name, *output.type)) {
      streams.push_back(std::move(*experiment));
    } else if (is(output, message_type<Forecast>())) {
      streams.push_back(forecast_stream(name, plan.torque));
    } else if (is(output, message_type<DeviceState>()) && output.name == "state") {
      streams.push_back(handle_stream(name));
    } else if (is(output, message_type<SafetyState>())) {
      streams.push_back(safety_stream(name));
    } else if (is(output, message_type<BodyStates>()) && output.name == "bodies") {
      for (std::size_t i = 0; i < moving.size(); ++i) {
        if (moving[i]) streams.push_back(body_stream(name, i, *moving[i]));
      }
    } else if (is(output, message_type<BodyPoses>())) {
      add_shapes_of(node.name, name, drawn, streams);
    } else if (is(output, message_type<PhysicsState>())) {
      streams.push_back(contact_count_stream(name));
      if (!has_bodies && !moving.empty() && moving.front()) streams.push_back(tool_stream(name, *moving.front()));
    } else if (is(output, message_type<ContactSet>())) {
      streams.push_back(contacts_stream(name));
    } else if (is(output, message_type<DeformedSurfaces>())) {
      streams.push_back(surface_stream(name));
    } else if (is(output, message_type<LocalContacts>())) {
      streams.push_back(patch_stream(name));
    }
  }
}

}  // namespace

std::vector<ShownStream> shown_streams(const Plan& plan) {
  return shown_streams(plan, drawn_scene(plan.graph));
}

std::vector<ShownStream> shown_streams(const Plan& plan, const DrawnScene& drawn) {
  bool has_bodies = false;
  for (const NodeSpec& node : plan.nodes) {
    for (const OutputInfo& output : node.info->outputs) {
      has_bodies = has_bodies || (is(output, message_type<BodyStates>()) && output.name == "bodies");
    }
  }
  const std::optional<MethodSwitch> methods = method_switch(plan);
  std::vector<ShownStream> streams;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const std::size_t before = streams.size();
    add_streams_of(plan, drawn, n, has_bodies, streams);
    if (!methods) continue;
    for (const MethodSwitch::Choice& choice : methods->choices) {
      if (std::find(choice.nodes.begin(), choice.nodes.end(), n) == choice.nodes.end()) continue;
      for (std::size_t i = before; i < streams.size(); ++i) streams[i].method = choice.value;
    }
  }
  return streams;
}

std::vector<ShownStream> blind_streams(const Plan& plan, const DrawnScene& drawn) {
  const bool mouse = std::any_of(plan.nodes.begin(), plan.nodes.end(),
                                 [](const NodeSpec& node) { return node.info->type == "device.mouse"; });
  std::vector<ShownStream> streams = shown_streams(plan, drawn);
  std::erase_if(streams, [mouse](const ShownStream& stream) {
    const std::string& role = stream.role;
    return role != "body" && role != "surface" && role != "handle" && role != "safety" && role != "experiment" &&
           !(mouse && role == "commanded");
  });
  for (ShownStream& stream : streams) stream.method.clear();
  return streams;
}

ShownStream reference_stream(const std::string& name, bool torque) {
  return wrench_stream("reference", name, torque, false);
}

std::optional<MethodSwitch> method_switch(const Plan& plan) {
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const NodeInfo& info = *plan.nodes[n].info;
    for (const ParamInfo& param : info.params) {
      const bool switches = param.tunable && param.kind == ParamKind::choice &&
                            std::all_of(param.choices.begin(), param.choices.end(),
                                        [&info](const std::string& choice) { return info.input(choice) != nullptr; });
      if (!switches) continue;
      MethodSwitch found{plan.nodes[n].name + "." + param.name, {}};
      std::multiset<std::size_t> used;
      for (std::size_t i = 0; i < info.inputs.size(); ++i) {
        if (std::find(param.choices.begin(), param.choices.end(), info.inputs[i].name) == param.choices.end()) continue;
        const std::vector<std::size_t> nodes = makers_of(plan, n, i);
        if (nodes.empty()) continue;
        MethodSwitch::Choice choice{info.inputs[i].name, method_label(plan, nodes), nodes};
        used.insert(choice.nodes.begin(), choice.nodes.end());
        found.choices.push_back(std::move(choice));
      }
      for (MethodSwitch::Choice& choice : found.choices) {
        std::erase_if(choice.nodes, [&used](std::size_t node) { return used.count(node) > 1; });
      }
      if (found.choices.size() > 1) return found;
    }
  }
  return std::nullopt;
}

}  // namespace tactor
