#include <algorithm>
#include <array>
#include <cstdio>

#include "framework/graph/format.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/spec.hpp"
#include "framework/graph/texts.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

// A double-quoted scalar, in which every text can be written.
std::string quote(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      std::array<char, 8> escape{};
      std::snprintf(escape.data(), escape.size(), "\\x%02x", static_cast<unsigned>(byte));
      result += escape.data();
    } else {
      result += c;
    }
  }
  return result + "\"";
}

std::string list(const std::vector<double>& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + number_text(values[i]);
  return text + "]";
}

std::string list(const Vec3& v) {
  return list(std::vector<double>{v.x, v.y, v.z});
}

std::string seconds(Duration duration) {
  return number_text(duration.seconds());
}

struct WriteValue {
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return number_text(value); }
  std::string operator()(const std::string& value) const { return quote(value); }
  std::string operator()(const std::vector<double>& values) const { return list(values); }
  std::string operator()(const Table& table) const {
    if (table.rows() == 0) return "[]";
    std::string text;
    for (std::size_t r = 0; r < table.rows(); ++r) {
      const auto first = table.values.begin() + static_cast<std::ptrdiff_t>(r * table.columns);
      text += "\n      - " + list({first, first + static_cast<std::ptrdiff_t>(table.columns)});
    }
    return text;
  }
  std::string operator()(const Mapping& mapping) const {
    if (mapping.empty()) return "{}";
    std::string text;
    for (const auto& [key, value] : mapping) text += "\n      " + quote(key) + ": " + quote(value);
    return text;
  }
};

std::string write_cost(const CostModel& cost) {
  if (cost.kind == CostModel::Kind::none) return "none";
  if (cost.kind == CostModel::Kind::trace) return "{trace: " + quote(cost.trace_file.string()) + "}";
  std::string text = cost.kind == CostModel::Kind::constant
                         ? "{constant: " + seconds(cost.base)
                         : "{per_contact: " + seconds(cost.each) + ", base: " + seconds(cost.base);
  text += ", jitter: " + number_text(cost.jitter) + ", min: " + seconds(cost.min);
  if (cost.max) text += ", max: " + seconds(*cost.max);
  return text + "}";
}

std::string motion_word(Motion motion) {
  switch (motion) {
    case Motion::fixed:
      return "static";
    case Motion::translation:
      return "translation";
    case Motion::rigid:
      return "rigid";
    case Motion::deformable:
      break;
  }
  return "deformable";
}

std::string write_region(const FixedRegion& region) {
  if (const auto* box = std::get_if<BoxRegion>(&region)) {
    return "{box: {low: " + list(box->low) + ", high: " + list(box->high) + "}}";
  }
  if (const auto* half = std::get_if<HalfSpaceRegion>(&region)) {
    return "{behind: {p: " + list(half->p) + ", n: " + list(half->n) + "}}";
  }
  return "{faces: " + quote(std::get<NamedFaces>(region).name) + "}";
}

template <class Line>
void write_deformable(const Deformable& d, const Line& line) {
  line("young", number_text(d.young));
  line("poisson", number_text(d.poisson));
  line("density", number_text(d.density));
  line("damping", number_text(d.damping));
  line("drag", number_text(d.drag));
  if (d.cell_size > 0) {
    line("cell_size", number_text(d.cell_size));
  } else {
    line("tetrahedra", std::to_string(d.tetrahedra));
  }
  std::string fixed;
  for (const FixedRegion& region : d.fixed) fixed += (fixed.empty() ? "" : ", ") + write_region(region);
  if (!fixed.empty()) line("fixed", "[" + fixed + "]");
  std::string inclusions;
  for (std::size_t i = 0; i < d.inclusions.size(); ++i) {
    const Inclusion& one = d.inclusions[i];
    inclusions += (i == 0 ? "inclusion_" : ", inclusion_") + std::to_string(i + 1) + ": {p: " + list(one.p) +
                  ", radius: " + number_text(one.radius) + ", young: " + number_text(one.young) + "}";
  }
  if (!inclusions.empty()) line("inclusions", "{" + inclusions + "}");
}

std::string write_body(const Body& body) {
  std::string text = "    " + body.name + ":\n";
  const auto line = [&](const std::string& key, const std::string& value) {
    text += "      " + key + ": " + value + "\n";
  };
  std::visit(
      [&](const auto& shape) {
        using S = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<S, MeshShape>) {
          line("mesh", quote(shape.file.string()));
          if (shape.scale) line("scale", number_text(*shape.scale));
        } else if constexpr (std::is_same_v<S, SphereShape>) {
          line("sphere", "{radius: " + number_text(shape.radius) + "}");
        } else if constexpr (std::is_same_v<S, CapsuleShape>) {
          line("capsule", "{radius: " + number_text(shape.radius) + ", length: " + number_text(shape.length) + "}");
        } else if constexpr (std::is_same_v<S, BoxShape>) {
          line("box", "{size: " + list(shape.size) + "}");
        } else {
          static_assert(std::is_same_v<S, PlaneShape>);
          line("plane", "{}");
        }
      },
      body.shape);
  const Quat& R = body.X_WB.R;
  line("pose", "{p: " + list(body.X_WB.p) + ", quaternion: " + list(std::vector<double>{R.w, R.x, R.y, R.z}) + "}");
  line("motion", motion_word(body.motion));
  if (body.motion == Motion::deformable) {
    write_deformable(body.deformable, line);
  } else {
    line("mass", number_text(body.mass));
  }
  if (body.inertia) line("inertia", list(*body.inertia));
  const Material& m = body.material;
  line("material", "{stiffness: " + number_text(m.stiffness) + ", damping: " + number_text(m.damping) +
                       ", friction: " + number_text(m.friction) + ", patch_area: " + number_text(m.patch_area) + "}");
  return text;
}

std::string write_live(const LiveSettings& live) {
  std::string text = "live:\n  on_missing_privilege: " + word(live.on_missing_privilege) +
                     "\n  on_stall: " + word(live.on_stall) + "\n  stall_timeout: " + seconds(live.stall_timeout) +
                     "\n  impose_cost: " + (live.impose_cost ? "true" : "false") + "\n  pool: {";
  if (live.pool_workers > 0) text += "workers: " + std::to_string(live.pool_workers) + ", ";
  text += "policy: " + word(live.pool.policy);
  if (live.pool.policy != SchedulingPolicy::other) text += ", priority: " + std::to_string(live.pool.priority);
  if (live.pool.cpu) text += ", cpu: " + std::to_string(*live.pool.cpu);
  return text + "}\n";
}

std::string write_scheduling(const Scheduling& scheduling) {
  std::string text = "    lane: " + word(scheduling.lane) + "\n";
  if (!scheduling.thread.empty()) text += "    thread: " + scheduling.thread + "\n";
  if (scheduling.policy) text += "    policy: " + word(*scheduling.policy) + "\n";
  if (scheduling.priority) text += "    priority: " + std::to_string(*scheduling.priority) + "\n";
  if (scheduling.cpu) text += "    cpu: " + std::to_string(*scheduling.cpu) + "\n";
  return text;
}

std::string write_value(const NodeSpec& node, std::size_t i) {
  const std::string value = std::visit(WriteValue{}, node.params[i]);
  return "    " + node.info->params[i].name + ":" + (value.starts_with('\n') ? "" : " ") + value + "\n";
}

/// Whether the parameter has the rate of the haptic loop, which the graph gives.
bool is_rate_of(const GraphSpec& graph, const NodeSpec& node, std::size_t i) {
  return node.info->haptic_rate && i == node.info->rate_parameter && node.params[i] == ParamValue(graph.rate);
}

std::string write_type(const NodeInfo& info) {
  return info.python.empty() ? "    type: " + info.type + "\n" : "    python: " + quote(info.python) + "\n";
}

std::string write_node(const GraphSpec& graph, const NodeSpec& node) {
  std::string text = "  " + node.name + ":\n" + write_type(*node.info);
  for (std::size_t i = 0; i < node.params.size(); ++i) {
    if (!is_rate_of(graph, node, i)) text += write_value(node, i);
  }
  return text + "    cost: " + write_cost(node.cost) + "\n" + write_scheduling(node.scheduling);
}

std::string write_edge(const EdgeSpec& edge) {
  std::string text =
      "  - {from: " + edge.from_node + "." + edge.from_port + ", to: " + edge.to_node + "." + edge.to_port;
  if (!edge.queue_is_default) text += ", queue: " + quote(queue_text(edge.queue));
  if (edge.delay.ns > 0) text += ", delay: " + seconds(edge.delay);
  return text + "}\n";
}

/// A node whose type is another: a file that extends takes nothing over then.
std::string overlay_new_type(const GraphSpec& graph, const NodeSpec& to) {
  std::string text = write_type(*to.info);
  for (std::size_t i = 0; i < to.params.size(); ++i) {
    const bool is_default = to.info->params[i].default_value == to.params[i];
    if (!is_default && !is_rate_of(graph, to, i)) text += write_value(to, i);
  }
  if (to.cost.kind != CostModel::Kind::none) text += "    cost: " + write_cost(to.cost) + "\n";
  if (write_scheduling(to.scheduling) != write_scheduling(default_scheduling(*to.info))) {
    text += write_scheduling(to.scheduling);
  }
  return text;
}

std::string overlay_node(const GraphSpec& graph, const NodeSpec& from, const NodeSpec& to) {
  std::string text;
  if (from.info != to.info) {
    text = overlay_new_type(graph, to);
  } else {
    for (std::size_t i = 0; i < to.params.size(); ++i) {
      if (from.params[i] != to.params[i] && !is_rate_of(graph, to, i)) text += write_value(to, i);
    }
    if (write_cost(from.cost) != write_cost(to.cost)) text += "    cost: " + write_cost(to.cost) + "\n";
    if (write_scheduling(from.scheduling) != write_scheduling(to.scheduling)) text += write_scheduling(to.scheduling);
  }
  return text.empty() ? text : "  " + to.name + ":\n" + text;
}

std::string overlay_body(const Body& from, const Body& to) {
  std::string text;
  if (from.motion != to.motion) text += "      motion: " + motion_word(to.motion) + "\n";
  if (from.deformable.tetrahedra != to.deformable.tetrahedra) {
    text += "      tetrahedra: " + std::to_string(to.deformable.tetrahedra) + "\n";
  }
  std::string material;
  const auto part = [&material](const char* key, double before, double after) {
    if (before == after) return;
    material += (material.empty() ? "" : ", ") + std::string(key) + ": " + number_text(after);
  };
  part("stiffness", from.material.stiffness, to.material.stiffness);
  part("damping", from.material.damping, to.material.damping);
  part("friction", from.material.friction, to.material.friction);
  part("patch_area", from.material.patch_area, to.material.patch_area);
  if (!material.empty()) text += "      material: {" + material + "}\n";
  return text.empty() ? text : "    " + to.name + ":\n" + text;
}

/// The parts of `to` told against those of `from` of the same name.
template <class Part, class Tell>
std::string overlay_parts(const std::vector<Part>& from, const std::vector<Part>& to, const Tell& tell) {
  std::string text;
  for (const Part& part : to) {
    for (const Part& before : from) {
      if (before.name == part.name) text += tell(before, part);
    }
  }
  return text;
}

}  // namespace

std::string to_overlay(const GraphSpec& from, const GraphSpec& to, const std::string& title,
                       const std::vector<std::string>& extends) {
  std::string files;
  for (const std::string& file : extends) files += (files.empty() ? "" : ", ") + quote(file);
  std::string text = "title: " + quote(title) + "\nextends: [" + files + "]\n";
  if (from.rate != to.rate) text += "rate: " + number_text(to.rate) + "\n";
  const std::string bodies = overlay_parts(from.scene.bodies, to.scene.bodies, overlay_body);
  if (!bodies.empty()) text += "scene:\n  bodies:\n" + bodies;
  const std::string nodes = overlay_parts(from.nodes, to.nodes, [&to](const NodeSpec& before, const NodeSpec& node) {
    return overlay_node(to, before, node);
  });
  if (!nodes.empty()) text += "nodes:\n" + nodes;
  std::string edges;
  for (const EdgeSpec& edge : from.edges) {
    const auto same = [&edge](const EdgeSpec& e) { return e.name() == edge.name(); };
    if (std::none_of(to.edges.begin(), to.edges.end(), same)) edges += "  - " + edge.name() + ": ~\n";
  }
  return edges.empty() ? text : text + "edges:\n" + edges;
}

std::string to_yaml(const GraphSpec& spec) {
  std::string text = "format: " + std::to_string(file_format) + "\n";
  if (!spec.title.empty()) text += "title: " + quote(spec.title) + "\n";
  text += std::string("clock: ") + (spec.clock == Clock::real ? "real" : "virtual") + "\n";
  text += "duration: " + seconds(spec.duration) + "\n";
  text += "seed: " + std::to_string(spec.seed) + "\n";
  text += "rate: " + number_text(spec.rate) + "\n";
  text += write_live(spec.live);
  text += "scene:\n  gravity: " + list(spec.scene.gravity_W) + "\n";
  if (const Camera& camera = spec.scene.camera; camera != Camera{}) {
    text += "  camera: {from: " + list(camera.from_W) + ", up: " + list(camera.up_W) + "}\n";
  }
  if (!spec.scene.tool_name.empty()) text += "  tool: " + spec.scene.tool_name + "\n";
  text += spec.scene.bodies.empty() ? "  bodies: {}\n" : "  bodies:\n";
  for (const Body& body : spec.scene.bodies) text += write_body(body);
  text += "nodes:\n";
  for (const NodeSpec& node : spec.nodes) text += write_node(spec, node);
  text += spec.edges.empty() ? "edges: []\n" : "edges:\n";
  for (const EdgeSpec& edge : spec.edges) text += write_edge(edge);
  text += spec.record.empty() ? "record: []\n" : "record:\n";
  for (const std::string& stream : spec.record) text += "  - " + stream + "\n";
  return text;
}

}  // namespace tactor
