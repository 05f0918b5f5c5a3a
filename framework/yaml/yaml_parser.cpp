#include "framework/yaml/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <unordered_map>

#include "framework/core/read_budget.hpp"

namespace tactor {

namespace {

// Ends the parse; the diagnostic is written already.
struct Stop {};

/// What a value is made of, with everything in it.
struct Extent {
  std::size_t values = 1;
  std::size_t depth = 1;
  std::size_t bytes = 0;  // of memory
};

struct Anchored {
  Tree tree;
  Extent extent;
};

class TreeBuilder final : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string& file, std::size_t size, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics), budget_(file, size) {}

  [[nodiscard]] bool done() const { return done_; }
  Tree take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ > 0) fail(place(mark), "expected the end of the file, found a second document or trailing text");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (awaits_key()) fail(place(mark), "expected a name as the key, found nothing");
    Tree tree;
    tree.place = place(mark);
    add_leaf(mark, std::move(tree), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check_tag(mark, tag);
    if (awaits_key()) {
      Frame& frame = frames_.back();
      frame.has_key = true;
      frame.key = value;
      frame.key_place = place(mark);
      check_key(frame);
      return;
    }
    Tree tree;
    tree.kind = Tree::Kind::scalar;
    tree.place = place(mark);
    tree.text = value;
    tree.quoted = tag == "!";
    add_leaf(mark, std::move(tree), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (awaits_key()) fail(place(mark), "expected a name as the key, found an alias");
    const auto it = anchors_.find(anchor);
    if (it == anchors_.end()) fail(place(mark), "the alias stands inside the value it refers to");
    const Extent& extent = it->second.extent;
    count(mark, extent.values);
    check_depth(mark, extent.depth);
    take(place(mark), extent.bytes);
    add(it->second.tree, 0, extent);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Tree::Kind::sequence);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Tree::Kind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Frame {
    Tree tree;
    YAML::anchor_t anchor = 0;
    Extent extent;
    bool has_key = false;
    bool duplicate = false;
    std::string key;
    SourceLocation key_place;
    std::unordered_map<std::string, int> lines;  // of the keys so far
  };

  [[nodiscard]] SourceLocation place(const YAML::Mark& mark) const { return {file_, mark.line + 1, mark.column + 1}; }

  [[noreturn]] void fail(const SourceLocation& where, std::string message) {
    diagnostics_.error(where, std::move(message));
    throw Stop{};
  }

  void check_tag(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?" || tag == "!") return;
    diagnostics_.error(place(mark), "expected a value without a tag, found the tag " + tag + "; leave the tag out");
  }

  void check_key(Frame& frame) {
    frame.duplicate = false;
    if (frame.lines.size() >= max_yaml_keys) {
      fail(frame.key_place, "expected at most " + std::to_string(max_yaml_keys) + " keys in a map, found more");
    }
    if (frame.key == "<<") {
      diagnostics_.error(frame.key_place, "merge keys (<<) are not supported; use extends or repeat the keys");
      frame.duplicate = true;
    } else if (const auto [first, added] = frame.lines.emplace(frame.key, frame.key_place.line); !added) {
      diagnostics_.error(frame.key_place, "the key \"" + frame.key + "\" is there twice; it is first in line " +
                                              std::to_string(first->second));
      frame.duplicate = true;
    }
  }

  [[nodiscard]] bool awaits_key() const {
    return !frames_.empty() && frames_.back().tree.is_map() && !frames_.back().has_key;
  }

  void count(const YAML::Mark& mark, std::size_t values) {
    values_ += values;
    if (values_ > max_yaml_values) {
      fail(place(mark),
           "expected at most " + std::to_string(max_yaml_values) + " values with aliases expanded, found more");
    }
  }

  void take(const SourceLocation& where, std::size_t bytes) {
    if (!budget_.holds(bytes)) fail(where, budget_.refusal());
  }

  /// The memory for a value, its key, and its place, which has the name of the file.
  [[nodiscard]] std::size_t bytes_for(std::size_t text) const {
    return sizeof(TreeEntry) + 2 * file_.size() + text +
           (awaits_key() || frames_.empty() ? 0 : frames_.back().key.size());
  }

  void check_depth(const YAML::Mark& mark, std::size_t below) {
    if (frames_.size() + below > max_yaml_depth) {
      fail(place(mark), "expected at most " + std::to_string(max_yaml_depth) + " levels of nesting, found more");
    }
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Tree::Kind kind) {
    check_tag(mark, tag);
    if (awaits_key()) {
      fail(place(mark),
           std::string("expected a name as the key, found ") +
               (kind == Tree::Kind::map ? "a map (or a { without its })" : "a list (or a [ without its ])"));
    }
    check_depth(mark, 1);
    count(mark, 1);
    const std::size_t bytes = bytes_for(0);
    take(place(mark), bytes);
    Frame frame;
    frame.extent.bytes = bytes;
    frame.tree.kind = kind;
    frame.tree.place = place(mark);
    frame.anchor = anchor;
    frames_.push_back(std::move(frame));
  }

  void close() {
    Frame frame = std::move(frames_.back());
    frames_.pop_back();
    add(std::move(frame.tree), frame.anchor, frame.extent);
  }

  void add_leaf(const YAML::Mark& mark, Tree tree, YAML::anchor_t anchor) {
    count(mark, 1);
    const std::size_t bytes = bytes_for(tree.text.size());
    take(place(mark), bytes);
    add(std::move(tree), anchor, {1, 1, bytes});
  }

  void add(Tree tree, YAML::anchor_t anchor, const Extent& extent) {
    if (anchor != 0) {
      // An alias needs a copy.
      take(tree.place, extent.bytes);
      anchors_[anchor] = {tree, extent};
    }
    if (frames_.empty()) {
      root_ = std::move(tree);
      done_ = true;
      return;
    }
    Frame& frame = frames_.back();
    frame.extent.values += extent.values;
    frame.extent.bytes += extent.bytes;
    frame.extent.depth = std::max(frame.extent.depth, extent.depth + 1);
    if (frame.tree.is_sequence()) {
      frame.tree.items.push_back(std::move(tree));
      return;
    }
    frame.has_key = false;
    if (!frame.duplicate) frame.tree.entries.push_back({std::move(frame.key), frame.key_place, std::move(tree)});
  }

  const std::string& file_;
  Diagnostics& diagnostics_;
  ReadBudget budget_;
  std::vector<Frame> frames_;
  std::map<YAML::anchor_t, Anchored> anchors_;
  Tree root_;
  std::size_t values_ = 0;
  int documents_ = 0;
  bool done_ = false;
};

// The parser's own words, with what usually is behind them.
std::string plain_message(const std::string& message) {
  struct Plain {
    std::string_view said;
    std::string_view means;
  };
  static constexpr Plain table[] = {
      {"end of map not found",
       "the line does not fit the map above it: check the indentation and the colon after the key"},
      {"end of sequence not found", "the line does not fit the list above it: check the indentation and the dash"},
      {"end of map flow not found", "a { has no }"},
      {"end of sequence flow not found", "a [ has no ]"},
      {"illegal map value", "a colon is not allowed here: put a text with a colon into quotes"},
      {"illegal block entry", "a list item (dash) is not allowed here: check the indentation"},
      {"illegal map key", "a key is not allowed here: check the indentation"},
      {"illegal EOF in scalar", "a quote is not closed"},
      {"illegal flow end", "a ] or } has no opening bracket"},
      {"illegal tab when looking for indentation", "a tab is used for indentation: use spaces"},
      {"the referenced anchor is not defined", "the alias refers to no anchor above it"},
      {"unknown token", "this character cannot begin a value: put the text into quotes"},
      {"bad file", "it is nested too deeply or cannot be read"},
  };
  for (const Plain& p : table) {
    // Newer releases add what they found: `the referenced anchor is not defined: time`.
    if (message == p.said || message.starts_with(std::string(p.said) + ": ")) return std::string(p.means);
  }
  return message;
}

// The column of a tab in front of the text of a line; 0 where there is none. Lines count from 1.
int tab_in_indentation(const std::string& text, int line) {
  std::size_t begin = 0;
  for (int i = 1; i < line; ++i) {
    begin = text.find('\n', begin);
    if (begin == std::string::npos) return 0;
    ++begin;
  }
  const std::size_t end = std::min(text.find_first_not_of(" \t", begin), text.size());
  const std::size_t tab = text.find('\t', begin);
  return tab < end ? static_cast<int>(tab - begin) + 1 : 0;
}

// Refuses what no text file holds, before the parser sees it.
bool check_characters(const std::string& text, const std::string& file, Diagnostics& diagnostics) {
  SourceLocation place{file, 1, 1};
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x80) {
      if ((byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r') || byte == 0x7f) {
        diagnostics.error(place, "expected text, found the control character " + std::to_string(byte));
        return false;
      }
      ++i;
      ++place.column;
      if (byte == '\n') {
        ++place.line;
        place.column = 1;
      }
      continue;
    }
    const int more = byte >= 0xc2 && byte <= 0xdf   ? 1
                     : byte >= 0xe0 && byte <= 0xef ? 2
                     : byte >= 0xf0 && byte <= 0xf4 ? 3
                                                    : 0;
    char32_t code = more == 1 ? byte & 0x1fU : more == 2 ? byte & 0x0fU : byte & 0x07U;
    bool good = more > 0 && i + static_cast<std::size_t>(more) < text.size();
    for (int k = 1; good && k <= more; ++k) {
      const auto next = static_cast<unsigned char>(text[i + static_cast<std::size_t>(k)]);
      good = (next & 0xc0U) == 0x80U;
      code = (code << 6U) | (next & 0x3fU);
    }
    good = good && !(more == 2 && (code < 0x800 || (code >= 0xd800 && code <= 0xdfff))) &&
           !(more == 3 && (code < 0x10000 || code > 0x10ffff));
    if (!good) {
      diagnostics.error(place, "expected text in UTF-8, found other bytes");
      return false;
    }
    i += static_cast<std::size_t>(more) + 1;
    place.column += more + 1;
  }
  return true;
}

}  // namespace

std::optional<Tree> parse_yaml(const std::string& text, const std::string& file, Diagnostics& diagnostics) {
  if (text.size() > max_yaml_bytes) {
    diagnostics.error({file, 0, 0}, "expected at most " + std::to_string(max_yaml_bytes) + " bytes of YAML, found " +
                                        std::to_string(text.size()));
    return std::nullopt;
  }
  if (!check_characters(text, file, diagnostics)) return std::nullopt;
  // Without the last line breaks the parser sees a quote that is open at the end of the file, which it else lets pass.
  std::istringstream stream(text.substr(0, text.find_last_not_of(" \t\r\n") + 1));
  TreeBuilder builder(file, text.size(), diagnostics);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const Stop&) {
    return std::nullopt;
  } catch (const YAML::Exception& e) {
    const bool placed = e.mark.line >= 0 && e.mark.column >= 0;
    SourceLocation place =
        placed ? SourceLocation{file, e.mark.line + 1, e.mark.column + 1} : SourceLocation{file, 0, 0};
    std::string message = plain_message(e.msg);
    if (const int tab = tab_in_indentation(text, place.line); tab > 0) {
      place.column = tab;
      message = "a tab is used for indentation: use spaces";
    }
    diagnostics.error(place, "not valid YAML: " + message);
    return std::nullopt;
  }
  return builder.take();
}

}  // namespace tactor
