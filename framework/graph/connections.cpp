#include <algorithm>
#include <charconv>
#include <map>

#include "framework/graph/format.hpp"
#include "framework/graph/merge.hpp"
#include "framework/graph/queue_bounds.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

template <class Port>
std::vector<std::string> names_of(const std::vector<Port>& ports) {
  std::vector<std::string> names;
  for (const Port& port : ports) names.push_back(port.name);
  return names;
}

template <class Port>
std::string ports_text(const std::vector<Port>& ports) {
  std::string text;
  for (const Port& port : ports) {
    text += (text.empty() ? "" : ", ") + port.name + " (" + std::string(port.type->name) + ")";
  }
  return text.empty() ? "none" : text;
}

struct End {
  const NodeSpec* node = nullptr;
  std::string port;
};

// Finds the nodes that edges and recordings name.
class Nodes {
 public:
  Nodes(const std::vector<NodeSpec>& nodes, const std::set<std::string>& broken) : broken_(broken) {
    for (const NodeSpec& node : nodes) {
      nodes_.emplace(node.name, &node);
      names_.push_back(node.name);
    }
    names_.insert(names_.end(), broken.begin(), broken.end());
  }

  // Nothing, with an error unless the node is a broken one.
  std::optional<End> find(const std::string& end, const SourceLocation& place, const std::string& what,
                          const std::string& expected, Diagnostics& diagnostics) const {
    const std::size_t dot = end.find('.');
    if (dot == std::string::npos || dot == 0 || dot + 1 == end.size() || end.find('.', dot + 1) != std::string::npos) {
      diagnostics.error(place, what + ": expected " + expected + ", found \"" + end + "\"");
      return std::nullopt;
    }
    const std::string name = end.substr(0, dot);
    if (broken_.contains(name)) return std::nullopt;
    const auto it = nodes_.find(name);
    if (it == nodes_.end()) {
      diagnostics.error(
          place, what + ": there is no node \"" + name + "\" (" + list_of(names_) + ")" + did_you_mean(name, names_));
      return std::nullopt;
    }
    return End{it->second, end.substr(dot + 1)};
  }

 private:
  std::map<std::string, const NodeSpec*, std::less<>> nodes_;
  std::vector<std::string> names_;
  const std::set<std::string>& broken_;
};

std::string named(const NodeSpec& node) {
  return node.name + " (" + node.info->type + ")";
}

const OutputInfo* find_output(const End& end, const SourceLocation& place, const std::string& what,
                              Diagnostics& diagnostics) {
  const OutputInfo* output = end.node->info->output(end.port);
  if (output != nullptr) return output;
  const auto& outputs = end.node->info->outputs;
  for (const OutputInfo& other : outputs) {
    if (other.former != end.port) continue;
    diagnostics.error(place, what + ": " + end.node->name + "." + end.port + renamed_text(other.name, place));
    return nullptr;
  }
  diagnostics.error(place, what + ": " + named(*end.node) + " has no output " + end.port + "; outputs of " +
                               end.node->name + ": " + ports_text(outputs) + did_you_mean(end.port, names_of(outputs)));
  return nullptr;
}

const InputInfo* find_input(const End& end, const SourceLocation& place, const std::string& what,
                            Diagnostics& diagnostics) {
  const InputInfo* input = end.node->info->input(end.port);
  if (input != nullptr) return input;
  const auto& inputs = end.node->info->inputs;
  for (const InputInfo& other : inputs) {
    if (other.former != end.port) continue;
    diagnostics.error(place, what + ": " + end.node->name + "." + end.port + renamed_text(other.name, place));
    return nullptr;
  }
  diagnostics.error(place, what + ": " + named(*end.node) + " has no input " + end.port + "; inputs of " +
                               end.node->name + ": " + ports_text(inputs) + did_you_mean(end.port, names_of(inputs)));
  return nullptr;
}

// `latest`, `queue(64, drop_oldest)`.
std::optional<Queue> read_queue(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  std::string text;
  for (const char c : tree.text) {
    if (c != ' ') text += c;
  }
  if (tree.is_scalar() && text == "latest") return Queue{};
  const std::size_t comma = text.find(',');
  if (tree.is_scalar() && text.starts_with("queue(") && text.ends_with(")") && comma != std::string::npos) {
    std::int64_t capacity = 0;
    const char* last = text.data() + comma;
    const auto number = std::from_chars(text.data() + 6, last, capacity);
    const std::string policy = text.substr(comma + 1, text.size() - comma - 2);
    static const std::map<std::string, QueuePolicy> policies{{"drop_oldest", QueuePolicy::drop_oldest},
                                                             {"drop_newest", QueuePolicy::drop_newest},
                                                             {"block", QueuePolicy::block}};
    const auto found = policies.find(policy);
    if (number.ec == std::errc{} && number.ptr == last && text[6] != '0' && capacity >= 1 && capacity <= most_queued &&
        found != policies.end()) {
      return Queue{found->second, static_cast<std::uint32_t>(capacity)};
    }
  }
  diagnostics.error(tree.place, path +
                                    ": expected latest or queue(n, drop_oldest|drop_newest|block) with n from 1 to " +
                                    std::to_string(most_queued) + ", found " + describe(tree));
  return std::nullopt;
}

void read_options(EdgeSpec& edge, const Tree& tree, const std::string& path, const std::vector<std::string>& keys,
                  Diagnostics& diagnostics) {
  check_keys(tree, path, "key", keys, diagnostics);
  if (const TreeEntry* queue = tree.find("queue")) {
    if (const auto q = read_queue(queue->value, path + ".queue", diagnostics)) {
      edge.queue = *q;
      edge.queue_is_default = false;
    }
  }
  if (const TreeEntry* delay = tree.find("delay")) {
    edge.delay = read_duration(delay->value, path + ".delay", false, diagnostics).value_or(Duration{});
  }
}

// What stands after the ends of an edge.
void read_edge_form(EdgeSpec& edge, const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  if (!tree.is_map()) return;
  const bool one_entry = tree.entries.size() == 1 && tree.entries[0].key.find("->") != std::string::npos;
  if (!one_entry) {
    read_options(edge, tree, path, {"from", "to", "queue", "delay"}, diagnostics);
    return;
  }
  const Tree& value = tree.entries[0].value;
  if (value.is_map()) {
    read_options(edge, value, path, {"queue", "delay"}, diagnostics);
  } else if (value.is_null()) {
    diagnostics.error(tree.place, path +
                                      ": expected a queue, found nothing; ~ takes out the edge into this input of the "
                                      "file that this one extends, and there is none");
  } else if (const auto queue = read_queue(value, path, diagnostics)) {
    edge.queue = *queue;
    edge.queue_is_default = false;
  }
}

}  // namespace

std::vector<EdgeSpec> read_edges(const Tree& tree, const std::vector<NodeSpec>& nodes,
                                 const std::set<std::string>& broken, Diagnostics& diagnostics) {
  std::vector<EdgeSpec> edges;
  if (tree.is_null()) return edges;
  if (!tree.is_sequence()) {
    diagnostics.error(tree.place, "edges: expected a list of \"node.output -> node.input\", found " + describe(tree));
    return edges;
  }
  const Nodes known(nodes, broken);
  std::map<std::string, const Tree*> fed;
  std::map<std::string, std::string> fed_from;
  for (std::size_t i = 0; i < tree.items.size(); ++i) {
    const Tree& item = tree.items[i];
    const std::string path = "edges[" + std::to_string(i) + "]";
    const std::optional<EdgeEnds> ends = edge_ends(item);
    if (!ends) {
      diagnostics.error(item.place, path + ": expected \"node.output -> node.input\", found " + describe(item));
      continue;
    }
    if (const auto input = fed_input(ends->from)) {
      diagnostics.error(item.place, path + ": into " + *input + ": expected an edge into " + *input +
                                        " in the file that this one is laid over, found none");
      continue;
    }
    EdgeSpec edge;
    edge.place = item.place;
    const std::string expected = "\"node.output -> node.input\"";
    const auto from = known.find(ends->from, item.place, path, expected, diagnostics);
    const auto to = known.find(ends->to, item.place, path, expected, diagnostics);
    read_edge_form(edge, item, path, diagnostics);
    const OutputInfo* output = from ? find_output(*from, item.place, path, diagnostics) : nullptr;
    const InputInfo* input = to ? find_input(*to, item.place, path, diagnostics) : nullptr;
    if (input != nullptr) {
      const auto [first, only] = fed.emplace(ends->to, &item);
      if (!only) {
        diagnostics.error(item.place, path + ": expected one edge into " + ends->to + ", found two: from " +
                                          fed_from[ends->to] + " (" + first->second->place.text() + ") and from " +
                                          ends->from);
        continue;
      }
      fed_from[ends->to] = ends->from;
    }
    if (output == nullptr || input == nullptr) continue;
    if (output->type != &any_message() && !same_type(*output->type, *input->type)) {
      const std::string other_layout =
          output->type->name == input->type->name ? "; both are called so, but their fields differ" : "";
      diagnostics.error(item.place, ends->from + " (" + std::string(output->type->name) + ") cannot feed " + ends->to +
                                        " (" + std::string(input->type->name) + "); inputs of " + to->node->name +
                                        ": " + ports_text(to->node->info->inputs) + other_layout);
      continue;
    }
    edge.from_node = from->node->name;
    edge.from_port = from->port;
    edge.to_node = to->node->name;
    edge.to_port = to->port;
    if (edge.queue_is_default) edge.queue = input->queue;
    if (const std::string trouble = queue_trouble(edge.queue, *input->type); !trouble.empty()) {
      diagnostics.error(item.place, path + ": " + trouble);
      continue;
    }
    edges.push_back(std::move(edge));
  }
  return edges;
}

std::vector<std::string> read_record(const Tree& tree, const std::vector<NodeSpec>& nodes,
                                     const std::set<std::string>& broken, Diagnostics& diagnostics) {
  std::vector<std::string> record;
  if (tree.is_null()) return record;
  if (!tree.is_sequence()) {
    diagnostics.error(tree.place, "record: expected a list of node.output, found " + describe(tree));
    return record;
  }
  const Nodes known(nodes, broken);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < tree.items.size(); ++i) {
    const Tree& item = tree.items[i];
    const std::string path = "record[" + std::to_string(i) + "]";
    if (!item.is_scalar()) {
      diagnostics.error(item.place, path + ": expected node.output, found " + describe(item));
      continue;
    }
    const auto end = known.find(item.text, item.place, path, "node.output", diagnostics);
    if (!end || find_output(*end, item.place, path, diagnostics) == nullptr) continue;
    if (!seen.insert(item.text).second) {
      diagnostics.error(item.place, path + ": " + item.text + " is there twice");
      continue;
    }
    record.push_back(item.text);
  }
  return record;
}

}  // namespace tactor
