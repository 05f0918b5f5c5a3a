#include "framework/graph/bind.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "framework/graph/merge.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

std::vector<std::string> role_names() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < role_count; ++i) names.emplace_back(name_of(static_cast<Role>(i)));
  return names;
}

/// What an entry of `bind` says.
struct Binding {
  std::string name;
  SourceLocation place;
  std::string role;  ///< empty: only `node` counts
  std::string node;  ///< empty: by name, else by role
  bool optional = false;
};

std::optional<Binding> read_binding(const TreeEntry& entry, Diagnostics& diagnostics) {
  const std::string path = "bind." + entry.key;
  Binding binding{.name = entry.key, .place = entry.place, .role = {}, .node = {}};
  const auto role = [&](const Tree& tree, const std::string& at) {
    const auto read = read_choice(tree, at, role_names(), diagnostics);
    binding.role = read.value_or("");
    return read.has_value();
  };
  if (!entry.value.is_map()) return role(entry.value, path) ? std::optional(binding) : std::nullopt;
  check_keys(entry.value, path, "key", {"role", "node", "optional"}, diagnostics);
  if (const Tree* said = entry.value.value("role"); said != nullptr && !role(*said, path + ".role")) return {};
  if (const Tree* said = entry.value.value("node")) {
    binding.node = read_text(*said, path + ".node", diagnostics).value_or("");
    if (binding.node.empty()) return {};
  }
  if (const Tree* said = entry.value.value("optional")) {
    binding.optional = read_boolean(*said, path + ".optional", diagnostics).value_or(false);
  }
  if (!binding.role.empty() || !binding.node.empty()) return binding;
  diagnostics.error(entry.place, path + ": expected a role, or a map with role or node, found neither");
  return {};
}

bool has_type(const Tree& node) {
  return node.find("type") != nullptr || node.find("python") != nullptr;
}

/// Takes `optional` out of an edge and says whether it was true.
bool take_optional(Tree& edge, Diagnostics& diagnostics) {
  if (!edge.is_map()) return false;
  const bool is_arrow = edge.entries.size() == 1 && edge.entries[0].key.find("->") != std::string::npos;
  Tree& options = is_arrow ? edge.entries[0].value : edge;
  const TreeEntry* found = options.find("optional");
  if (found == nullptr) return false;
  const bool optional = read_boolean(found->value, "optional", diagnostics).value_or(false);
  std::erase_if(options.entries, [](const TreeEntry& e) { return e.key == "optional"; });
  if (is_arrow && options.entries.empty()) {
    Tree plain;
    plain.kind = Tree::Kind::scalar;
    plain.place = edge.place;
    plain.text = edge.entries[0].key;
    edge = std::move(plain);
  }
  return optional;
}

/// An end of an edge, or of `into x.in`.
struct BoundEnd {
  std::string node, port;
  bool is_input = false;
  bool into = false;
  bool is_bound = false;     ///< its node is one of those that the child does not know
  bool is_resolved = false;  ///< the port is there, or nobody can tell
  [[nodiscard]] std::string text() const { return (into ? "into " : "") + node + "." + port; }
};

struct Edge {
  Tree* tree = nullptr;
  BoundEnd from, to;
  bool is_optional = false;
};

struct Port {
  std::string name;
  const MessageType* type = nullptr;
};

std::vector<Port> ports_of(const NodeInfo& info, bool inputs) {
  std::vector<Port> ports;
  for (const InputInfo& input : info.inputs) {
    if (inputs) ports.push_back({input.name, input.type});
  }
  for (const OutputInfo& output : info.outputs) {
    if (!inputs) ports.push_back({output.name, output.type});
  }
  return ports;
}

/// Binds one file to the graph below it.
class Binder {
 public:
  Binder(const Tree& parent, Tree& child, const TypeOfNode& type_of, Diagnostics& diagnostics)
      : below_(parent.value("nodes")),
        edges_below_(parent.value("edges")),
        child_(child),
        type_of_(type_of),
        diagnostics_(diagnostics) {}

  /// False, with errors, where a name cannot be bound.
  bool bind(const Tree& names) {
    const std::size_t before = diagnostics_.list().size();
    if (!expect_map(names, "bind", "a map of names to roles", diagnostics_)) return false;
    for (const TreeEntry& entry : names.entries) {
      const auto binding = read_binding(entry, diagnostics_);
      if (!binding) continue;
      const TreeEntry* own = own_node(entry.key);
      if (own != nullptr && has_type(own->value)) {
        bind_replacement(*binding, *own);
      } else {
        bind(*binding);
      }
    }
    if (diagnostics_.list().size() > before) return false;
    rename_nodes();
    rename_edges();
    rename_record();
    return diagnostics_.list().size() == before;
  }

 private:
  [[nodiscard]] const TreeEntry* own_node(const std::string& name) const {
    const Tree* nodes = child_.value("nodes");
    return nodes == nullptr ? nullptr : nodes->find(name);
  }
  [[nodiscard]] const TreeEntry* node_below(const std::string& name) const {
    return below_ == nullptr ? nullptr : below_->find(name);
  }

  /// `engine (mylab.physics, dynamics)`, for errors.
  [[nodiscard]] std::string described(const TreeEntry& node) const {
    const NodeInfo* info = type_of_(node);
    return node.key + (info == nullptr ? "" : " (" + info->type + ", " + std::string(name_of(info->role)) + ")");
  }

  void bind(const Binding& binding) {
    std::vector<std::string> found, names, described_names;
    const std::string by_name = binding.node.empty() ? binding.name : binding.node;
    if (below_ != nullptr) {
      for (const TreeEntry& node : below_->entries) {
        names.push_back(node.key);
        if (node.key == by_name) found = {node.key};
      }
    }
    if (found.empty() && binding.node.empty() && below_ != nullptr) {
      for (const TreeEntry& node : below_->entries) {
        const NodeInfo* info = own_node(node.key) == nullptr ? type_of_(node) : nullptr;
        if (info == nullptr || name_of(info->role) != binding.role) continue;
        found.push_back(node.key);
        described_names.push_back(described(node));
      }
    }
    if (found.size() == 1) {
      check_role(binding, found.front());
      bound_[binding.name] = found.front();
    } else if (found.empty() && binding.optional) {
      dropped_.insert(binding.name);
    } else {
      refuse(binding, names, described_names);
    }
  }

  /// Refuses a node that has the name alone, where another one has the role that the entry says. Where no node has that
  /// role, the name counts: a recorded force may stand in the place of a coupling.
  void check_role(const Binding& binding, const std::string& found) {
    const TreeEntry* own = own_node(binding.name);
    const NodeInfo* info = type_of_(*node_below(found));
    if (!binding.node.empty() || info == nullptr || name_of(info->role) == binding.role) return;
    if (own != nullptr && own->value.kind == Tree::Kind::null) return;  // it goes
    for (const TreeEntry& node : below_->entries) {
      const NodeInfo* other = own_node(node.key) == nullptr ? type_of_(node) : nullptr;
      if (other == nullptr || name_of(other->role) != binding.role) continue;
      diagnostics_.error(binding.place, "bind." + binding.name + ": expected a node of role " + binding.role +
                                            ", found " + described(*node_below(found)) + " by its name and " +
                                            described(node) + " by its role" + help_for(binding));
      return;
    }
  }

  /// A node of the child takes the place of the only one of the role whose ports it has too; else it is a new node.
  void bind_replacement(const Binding& binding, const TreeEntry& own) {
    const NodeInfo* type = type_of_(own);
    if (type == nullptr || below_ == nullptr || (binding.node.empty() && node_below(binding.name) != nullptr)) return;
    if (!binding.node.empty()) return bind(binding);
    std::vector<std::string> found, described_names;
    for (const TreeEntry& node : below_->entries) {
      const NodeInfo* info = own_node(node.key) == nullptr ? type_of_(node) : nullptr;
      if (info == nullptr || name_of(info->role) != binding.role || !fits(*type, binding.name, node.key)) continue;
      found.push_back(node.key);
      described_names.push_back(described(node));
    }
    if (found.size() == 1) bound_[binding.name] = found.front();
    if (found.size() > 1) refuse(binding, {}, described_names);
  }

  /// Whether the type has each port of the node below at which an edge stays, where the child calls that node `name`.
  [[nodiscard]] bool fits(const NodeInfo& type, const std::string& name, const std::string& node) const {
    const auto stays = [&](const std::string& input) {
      const Tree* own = child_.value("edges");
      return own == nullptr || std::none_of(own->items.begin(), own->items.end(), [&](const Tree& edge) {
               const std::optional<EdgeEnds> ends = edge_ends(edge);
               return ends && ends->to == name + "." + input;
             });
    };
    const auto has = [&](const Tree& edge) {
      const std::optional<EdgeEnds> ends = edge_ends(edge);
      if (!ends) return true;
      const auto port_of = [&](const std::string& end) { return end.substr(std::min(end.find('.') + 1, end.size())); };
      const std::string from = port_of(ends->from), to = port_of(ends->to);
      return (node_of(ends->from) != node || type.output(from) != nullptr) &&
             (node_of(ends->to) != node || type.input(to) != nullptr || !stays(to));
    };
    return edges_below_ == nullptr || std::all_of(edges_below_->items.begin(), edges_below_->items.end(), has);
  }

  [[nodiscard]] static std::string help_for(const Binding& binding) {
    return "; to name the node that is meant, lay a file with `extends` of this one over the graph instead that says "
           "`bind: {" +
           binding.name + ": {node: NAME}}`";
  }

  void refuse(const Binding& binding, const std::vector<std::string>& names, const std::vector<std::string>& found) {
    const std::string path = "bind." + binding.name;
    const std::string help = help_for(binding);
    if (!binding.node.empty()) {
      diagnostics_.error(binding.place, path + ".node: there is no node \"" + binding.node + "\" in the graph below (" +
                                            list_of(names) + ")" + did_you_mean(binding.node, names));
    } else if (found.empty()) {
      diagnostics_.error(binding.place, path + ": expected a node \"" + binding.name + "\" or one of role " +
                                            binding.role + " in the graph below (" + list_of(names) +
                                            "), found neither; add such a node to the graph" + help);
    } else {
      diagnostics_.error(binding.place, path + ": expected one node of role " + binding.role +
                                            " in the graph below, found " + std::to_string(found.size()) + ": " +
                                            list_of(found) + help);
    }
  }

  [[nodiscard]] std::string now(const std::string& name) const {
    const auto found = bound_.find(name);
    return found == bound_.end() ? name : found->second;
  }

  void rename_nodes() {
    TreeEntry* nodes = child_.find("nodes");
    if (nodes == nullptr) return;
    std::erase_if(nodes->value.entries, [&](const TreeEntry& node) { return dropped_.contains(node.key); });
    for (TreeEntry& node : nodes->value.entries) node.key = now(node.key);
  }

  void rename_record() {
    TreeEntry* record = child_.find("record");
    if (record == nullptr) return;
    std::erase_if(record->value.items, [&](const Tree& stream) { return dropped_.contains(node_of(stream.text)); });
    for (Tree& stream : record->value.items) {
      const std::string node = node_of(stream.text);
      if (!bound_.contains(node)) continue;
      const std::size_t dot = stream.text.find('.');
      const std::string port = dot == std::string::npos ? "" : stream.text.substr(dot + 1);
      // A port that an edge of the file names is the same here.
      const auto found = std::find_if(taken_.begin(), taken_.end(), [&](const auto& taken) {
        const auto& [at, is_input, name] = taken.first;
        return at == now(node) && !is_input && taken.second == port;
      });
      stream.text = now(node) + (dot == std::string::npos ? "" : ".") +
                    (found == taken_.end() ? port : std::get<2>(found->first));
    }
  }

  [[nodiscard]] std::optional<BoundEnd> read_end(const std::string& text, bool is_input) const {
    const std::optional<std::string> fed = fed_input(text);
    const std::string end = fed.value_or(text);
    const std::size_t dot = end.find('.');
    if (dot == std::string::npos) return std::nullopt;
    const std::string name = end.substr(0, dot);
    return BoundEnd{.node = now(name),
                    .port = end.substr(dot + 1),
                    .is_input = is_input || fed.has_value(),
                    .into = fed.has_value(),
                    .is_bound = bound_.contains(name)};
  }

  void rename_edges() {
    TreeEntry* list = child_.find("edges");
    if (list == nullptr) return;
    const auto is_dropped = [&](const std::string& end) {
      return dropped_.contains(node_of(fed_input(end).value_or(end)));
    };
    std::erase_if(list->value.items, [&](const Tree& edge) {
      const std::optional<EdgeEnds> ends = edge_ends(edge);
      return ends && (is_dropped(ends->from) || is_dropped(ends->to));
    });
    std::vector<Edge> edges;
    for (Tree& tree : list->value.items) {
      const std::optional<EdgeEnds> ends = edge_ends(tree);
      const auto from = ends ? read_end(ends->from, false) : std::nullopt;
      const auto to = ends ? read_end(ends->to, true) : std::nullopt;
      if (!from || !to || (!from->is_bound && !to->is_bound)) continue;
      edges.push_back({&tree, *from, *to, take_optional(tree, diagnostics_)});
    }
    // A port that has the right name belongs to that name, whatever the order; and one that must be there to its edge.
    for (Edge& edge : edges) {
      resolve_by_name(edge.from, edge.to);
      resolve_by_name(edge.to, edge.from);
    }
    for (const bool optional : {false, true}) {
      for (Edge& edge : edges) {
        if (edge.is_optional != optional) continue;
        resolve_by_type(edge.from, edge.to);
        resolve_by_type(edge.to, edge.from);
      }
    }
    std::set<const Tree*> without_port;
    for (Edge& edge : edges) {
      set_edge_ends(*edge.tree, {edge.from.text(), edge.to.text()});
      const bool is_there = edge.from.is_resolved && edge.to.is_resolved;
      if (edge.is_optional && !is_there) without_port.insert(edge.tree);
    }
    std::erase_if(list->value.items, [&](const Tree& edge) { return without_port.contains(&edge); });
  }

  /// The declaration of a node of the child, else of the graph below.
  [[nodiscard]] const NodeInfo* info_of(const std::string& name) const {
    const TreeEntry* own = own_node(name);
    if (own != nullptr && has_type(own->value)) return type_of_(*own);
    const TreeEntry* node = node_below(name);
    return node == nullptr ? nullptr : type_of_(*node);
  }

  /// The message type of the port that an end names; null where there is none, or it follows from parameters.
  [[nodiscard]] const MessageType* type_at(const BoundEnd& end) const {
    const NodeInfo* info = info_of(end.node);
    if (info == nullptr) return nullptr;
    for (const Port& port : ports_of(*info, end.is_input)) {
      if (port.name == end.port) return port.type == &any_message() ? nullptr : port.type;
    }
    return nullptr;
  }

  void resolve_by_name(BoundEnd& end, const BoundEnd& other) {
    const NodeInfo* info = info_of(end.node);
    if (!end.is_bound || info == nullptr) {
      end.is_resolved = true;
      return;
    }
    const MessageType* wanted = type_at(other);
    for (const Port& port : ports_of(*info, end.is_input)) {
      const bool suits = wanted == nullptr || port.type == &any_message() || same_type(*port.type, *wanted);
      if (port.name != end.port || !suits) continue;
      end.is_resolved = true;
      taken_[{end.node, end.is_input, port.name}] = end.port;
    }
  }

  void resolve_by_type(BoundEnd& end, const BoundEnd& other) {
    if (end.is_resolved) return;
    const NodeInfo* info = info_of(end.node);
    const MessageType* wanted = type_at(other);
    if (info == nullptr || wanted == nullptr) return;
    std::vector<std::string> found;
    for (const Port& port : ports_of(*info, end.is_input)) {
      if (port.type == &any_message() || !same_type(*port.type, *wanted)) continue;
      const auto taken = taken_.find({end.node, end.is_input, port.name});
      if (taken == taken_.end() || taken->second == end.port) found.push_back(port.name);
    }
    if (found.size() != 1) return;
    taken_[{end.node, end.is_input, found.front()}] = end.port;
    end.port = found.front();
    end.is_resolved = true;
  }

  const Tree* below_;
  const Tree* edges_below_;
  Tree& child_;
  const TypeOfNode& type_of_;
  Diagnostics& diagnostics_;
  std::map<std::string, std::string> bound_;                                 // to nodes of the graph below
  std::set<std::string> dropped_;                                            // optional, and not there
  std::map<std::tuple<std::string, bool, std::string>, std::string> taken_;  // ports by the names that they have
};

}  // namespace

bool lay_over(Tree& parent, Tree child, const TypeOfNode& type_of, Diagnostics& diagnostics) {
  const bool is_graph = parent.find("scene") != nullptr || parent.find("duration") != nullptr;
  const TreeEntry* found = child.find("bind");
  if (found != nullptr && is_graph && parent.find("bind") == nullptr) {
    const Tree names = found->value;
    std::erase_if(child.entries, [](const TreeEntry& entry) { return entry.key == "bind"; });
    if (!Binder(parent, child, type_of, diagnostics).bind(names)) return false;
  }
  merge_graph(parent, child);
  return true;
}

bool is_bound(const Tree& graph, const std::filesystem::path& file, Diagnostics& diagnostics) {
  const TreeEntry* names = graph.find("bind");
  if (names == nullptr) return true;
  diagnostics.error(names->place, "bind: expected a file that is laid over a graph, found " + file.string() +
                                      ", which is laid over none; a graph has a scene or a duration");
  return false;
}

}  // namespace tactor
