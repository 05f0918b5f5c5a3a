#include "framework/graph/migrate.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>

#include "framework/core/text.hpp"
#include "framework/graph/format.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

namespace {

/// Former names of parameters or ports and what they are now.
class Names {
 public:
  template <class List>
  void add(const List& list) {
    for (const auto& one : list) {
      current_.insert(one.name);
      if (!one.former.empty()) now_[one.former].insert(one.name);
    }
  }
  /// Nothing where the name is still in use, was never one, or has become several.
  [[nodiscard]] std::optional<std::string> now(const std::string& name) const {
    const auto found = now_.find(name);
    if (found == now_.end() || current_.contains(name) || found->second.size() > 1) return std::nullopt;
    return *found->second.begin();
  }

 private:
  std::set<std::string> current_;
  std::map<std::string, std::set<std::string>> now_;
};

struct NamesOfType {
  Names params, inputs, outputs;
  void add(const NodeInfo& info) {
    params.add(info.params);
    inputs.add(info.inputs);
    outputs.add(info.outputs);
  }
};

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

class Rewriter {
 public:
  Rewriter(const std::string& text, const std::vector<const NodeInfo*>& types) : text_(text) {
    // Places do not count the mark that tells the order of bytes.
    lines_.push_back(text.starts_with("\xEF\xBB\xBF") ? 3 : 0);
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') lines_.push_back(i + 1);
    }
    for (const NodeInfo* info : types) {
      any_.add(*info);
      by_type_[info->type].add(*info);
    }
  }

  Migrated rewrite(const Tree& file) {
    if (file.find("format") == nullptr && !file.entries.empty()) add_format(file);
    find_types(file);
    walk(file);
    std::sort(edits_.begin(), edits_.end(), [](const Edit& a, const Edit& b) { return a.offset < b.offset; });
    Migrated result{text_, {}};
    for (auto edit = edits_.rbegin(); edit != edits_.rend(); ++edit) {
      result.text.replace(edit->offset, edit->change.before.size(), edit->insert);
    }
    for (Edit& edit : edits_) result.changes.push_back(std::move(edit.change));
    return result;
  }

 private:
  struct Edit {
    std::size_t offset;
    std::string insert;
    Migration change;
  };

  void add_format(const Tree& file) {
    const SourceLocation& place = file.entries.front().place;
    const std::string line = "format: " + std::to_string(file_format);
    const std::size_t offset = offset_of(place);
    const std::size_t begin = lines_[static_cast<std::size_t>(place.line - 1)];
    const bool in_block = text_.find_first_not_of(" ", begin) == offset;
    edits_.push_back({offset, line + (in_block ? "\n" + std::string(offset - begin, ' ') : ", "), {place, "", line}});
  }

  /// Types of the nodes that say one, wherever in the file.
  void find_types(const Tree& tree) {
    for (const TreeEntry& entry : tree.entries) {
      if (entry.key == "nodes" && entry.value.is_map()) {
        for (const TreeEntry& node : entry.value.entries) {
          const Tree* type = node.value.value("type");
          if (type != nullptr && by_type_.contains(type->text)) type_of_[node.key] = type->text;
        }
      }
      find_types(entry.value);
    }
    for (const Tree& item : tree.items) find_types(item);
  }

  void walk(const Tree& tree) {
    for (const TreeEntry& entry : tree.entries) {
      if (entry.key == "nodes" && entry.value.is_map()) {
        for (const TreeEntry& node : entry.value.entries) {
          for (const TreeEntry& param : node.value.entries) {
            rename(param.place, offset_of(param.place), "", param.key, names_of(node.key).params.now(param.key));
          }
        }
      } else if (entry.key == "edges") {
        for (const Tree& edge : entry.value.items) rename_edge(edge);
      } else if (entry.key == "record") {
        for (const Tree& output : entry.value.items) {
          if (is_first_visit(output.place)) rename_end(output.place, offset_of(output.place), output.text, false);
        }
      } else if (entry.key == "set" || entry.key == "vary") {
        for (const TreeEntry& paths : entry.value.entries) {
          if (!is_first_visit(paths.place)) continue;
          std::size_t offset = offset_of(paths.place);
          for (const std::string& path : split(paths.key, ',')) {
            rename_path(paths.place, offset, std::string(trimmed(path)));
            offset = std::min(text_.find(',', offset), text_.size() - 1) + 1;
          }
        }
        walk(entry.value);
      } else {
        walk(entry.value);
      }
    }
    for (const Tree& item : tree.items) walk(item);
  }

  /// False where an alias leads to the same place again.
  bool is_first_visit(const SourceLocation& place) { return visited_.insert({place.line, place.column}).second; }

  static std::vector<std::string> split(const std::string& text, char at) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
      if (c == at) {
        parts.emplace_back();
      } else {
        parts.back() += c;
      }
    }
    return parts;
  }

  [[nodiscard]] const NamesOfType& names_of(const std::string& node) const {
    const auto type = type_of_.find(node);
    return type == type_of_.end() ? any_ : by_type_.at(type->second);
  }

  void rename_edge(const Tree& edge) {
    if (!is_first_visit(edge.place)) return;
    const auto both = [&](const SourceLocation& place, const std::string& text) {
      const std::size_t arrow = text.find("->"), offset = offset_of(place);
      if (arrow == std::string::npos) return;
      rename_end(place, offset, std::string(trimmed(std::string_view(text).substr(0, arrow))), false);
      const std::size_t written = text_.find("->", offset);
      if (written == std::string::npos) return;
      rename_end(place, written + 2, std::string(trimmed(std::string_view(text).substr(arrow + 2))), true);
    };
    if (edge.is_scalar()) both(edge.place, edge.text);
    for (const TreeEntry& entry : edge.entries) {
      both(entry.place, entry.key);
      if (entry.key != "from" && entry.key != "to") continue;
      const SourceLocation& place = entry.value.place;
      rename_end(place, offset_of(place), entry.value.text, entry.key == "to");
    }
  }

  /// `node.port`, written at that offset.
  void rename_end(const SourceLocation& place, std::size_t offset, const std::string& end, bool is_input) {
    const std::size_t dot = end.find('.');
    if (dot == std::string::npos) return;
    const NamesOfType& names = names_of(end.substr(0, dot));
    const std::string port = end.substr(dot + 1);
    rename(place, offset, end.substr(0, dot + 1), port, (is_input ? names.inputs : names.outputs).now(port));
  }

  /// `node.parameter`, perhaps behind `nodes.`, written at that offset.
  void rename_path(const SourceLocation& place, std::size_t offset, const std::string& path) {
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) return;
    const std::vector<std::string> parts = split(path.substr(0, dot), '.');
    rename(place, offset, path.substr(0, dot + 1), path.substr(dot + 1),
           names_of(parts.back()).params.now(path.substr(dot + 1)));
  }

  [[nodiscard]] std::size_t offset_of(const SourceLocation& place) const {
    const auto line = static_cast<std::size_t>(std::max(place.line, 1)) - 1;
    if (line >= lines_.size()) return text_.size();
    return std::min(lines_[line] + static_cast<std::size_t>(std::max(place.column, 1)) - 1, text_.size());
  }

  /// Replaces `before` behind `prefix` where they are written at that offset, perhaps behind an anchor, blanks or a
  /// quote. Where they are spelt otherwise, by escapes for example, nothing is replaced.
  void rename(const SourceLocation& place, std::size_t offset, const std::string& prefix, const std::string& before,
              const std::optional<std::string>& now) {
    if (!now) return;
    if (offset < text_.size() && text_[offset] == '&') offset = std::min(text_.find(' ', offset), text_.size());
    offset = std::min(text_.find_first_not_of(" \t\r\n\"'", offset), text_.size());
    const std::string wanted = prefix + before;
    const std::size_t end = offset + wanted.size(), written = offset + prefix.size();
    const bool is_there = text_.compare(offset, wanted.size(), wanted) == 0;
    if (!is_there || (end < text_.size() && is_word(text_[end])) || is_edited(written)) return;
    edits_.push_back({written, *now, {place, before, *now}});
  }

  [[nodiscard]] bool is_edited(std::size_t offset) const {
    return std::any_of(edits_.begin(), edits_.end(), [&](const Edit& e) { return e.offset == offset; });
  }

  const std::string& text_;
  std::vector<std::size_t> lines_;  // where each begins
  NamesOfType any_;                 // of all types
  std::map<std::string, NamesOfType> by_type_;
  std::map<std::string, std::string> type_of_;  // by node
  std::vector<Edit> edits_;
  std::set<std::pair<int, int>> visited_;  // lines and columns of what was renamed
};

}  // namespace

Migrated migrate(const std::string& text, const std::string& file, const std::vector<const NodeInfo*>& types,
                 Diagnostics& diagnostics) {
  const std::optional<Tree> tree = parse_yaml(text, file, diagnostics);
  if (!tree || diagnostics.any()) return {text, {}};
  Migrated result = Rewriter(text, types).rewrite(*tree);
  // A first key behind a question mark takes no key before it, and a new name may be there beside the former one.
  Diagnostics broken;
  const std::optional<Tree> again = parse_yaml(result.text, file, broken);
  const std::size_t added = tree->find("format") == nullptr && !tree->entries.empty() ? 1 : 0;
  if (again && !broken.any() && again->entries.size() == tree->entries.size() + added) return result;
  const std::string why = broken.any() ? broken.list().front().message : "its first key cannot stand behind another";
  diagnostics.error(tree->place, "expected a file that is valid when it is rewritten, found one that is not (" + why +
                                     "); write `format: 2` and the new names by hand");
  return {text, {}};
}

}  // namespace tactor
