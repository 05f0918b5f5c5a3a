#include "app/new/new_project.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <utility>

#include "app/output.hpp"
#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/installation.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_example_bytes = 1 << 20;

using Words = std::vector<std::pair<std::string, std::string>>;  // from the example's to the user's, in order

/// The example that a project is copied from, and the word in it that its node is called by.
struct Example {
  std::string folder;
  std::string node;  ///< empty: the project has no one node to name
  std::string usual_node;
};

Example example_of(ProjectKind kind) {
  switch (kind) {
    case ProjectKind::node:
      return {"node", "parabola", "predictor"};
    case ProjectKind::device:
      return {"device", "arm", "device"};
    case ProjectKind::message:
      return {"message", "", ""};
    case ProjectKind::study:
      return {"study", "", ""};
    case ProjectKind::physics:
      return {"physics", "", ""};
    case ProjectKind::mujoco:
      return {"mujoco", "", ""};
  }
  TACTOR_DEMAND(false);
}

/// `first_touch` -> `FirstTouch`.
std::string class_name(const std::string& node) {
  std::string name;
  bool begins = true;
  for (const char c : node) {
    if (c != '_') name += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    begins = c == '_';
  }
  return name;
}

void refuse_name_of_ours(const std::string& library) {
  const std::string file = "libtactor_" + library + ".so";
  if (fs::exists(library_folder() / "tactor" / file)) {
    throw InputError("tactor new: expected a name that no library of Tactor has, found \"" + library +
                     "\"; its nodes would never be found. Choose another");
  }
}

/// In one pass, so that what is put in is not looked at again.
std::string replaced(const std::string& text, const Words& words) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const auto found = std::find_if(words.begin(), words.end(), [&](const auto& word) {
      return text.compare(at, word.first.size(), word.first) == 0;
    });
    if (found == words.end()) {
      result += text[at++];
    } else {
      result += found->second;
      at += found->first.size();
    }
  }
  return result;
}

/// Without the marks by which a test runs the blocks of a page.
std::string without_marks(const std::string& text) {
  static const std::regex mark("<!-- block: [^\n]*\n");
  return std::regex_replace(text, mark, "");
}

std::vector<fs::path> copy_example(const std::string& folder, const fs::path& project, const Words& words) {
  const fs::path example = installation_prefix() / "share" / "tactor" / "examples" / folder;
  std::error_code error;
  std::vector<fs::path> files;
  // Python keeps a folder beside files that it has run.
  for (const auto& entry : fs::directory_iterator(example, error)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  if (error || files.empty()) {
    throw InputError("tactor new: " + example.string() + " is missing; install Tactor again, with its examples");
  }
  if (fs::exists(project)) {
    throw InputError("tactor new: " + project.string() + " is there already; choose another name, or another --in");
  }
  std::sort(files.begin(), files.end());
  std::set<fs::path> names;
  for (const fs::path& file : files) {
    const std::string name = replaced(file.filename().string(), words);
    if (names.insert(name).second) continue;
    throw InputError("tactor new: expected another name, because two files of the project would be called " + name);
  }
  fs::create_directories(project, error);
  if (error) throw InputError("tactor new: cannot make the folder " + project.string() + ": " + error.message());
  for (fs::path& file : files) {
    const fs::path target = project / replaced(file.filename().string(), words);
    write_file(target, replaced(without_marks(read_input_file(file, max_example_bytes)), words));
    file = target;
  }
  return files;
}

}  // namespace

std::vector<fs::path> new_project(ProjectKind kind, const std::string& name, const fs::path& folder) {
  static const std::regex form("([a-z][a-z0-9_]*)([.]([a-z][a-z0-9_]*))?");
  const Example example = example_of(kind);
  std::smatch parts;
  if (!std::regex_match(name, parts, form) || (example.node.empty() && parts[3].matched)) {
    throw InputError(
        fmt::format("tactor new: expected a name of small letters, digits and _, such as mylab{}, found \"{}\"",
                    example.node.empty() ? "" : " or mylab." + example.usual_node, name));
  }
  const std::string library = parts[1];
  const bool is_library = kind == ProjectKind::node || kind == ProjectKind::device || kind == ProjectKind::message;
  if (is_library) refuse_name_of_ours(library);
  Words words;
  if (!example.node.empty()) {
    const std::string node = parts[3].matched ? parts[3].str() : example.usual_node;
    words = {{"example." + example.node, library + "." + node},
             {example.node + ".cpp", node + ".cpp"},
             {class_name(example.node), class_name(node)}};
  }
  // Runs and studies are called after their file.
  words.emplace_back("graph.yaml", library + ".yaml");
  words.emplace_back("study.yaml", library + ".yaml");
  words.emplace_back("example", library);
  return copy_example(example.folder, folder / library, words);
}

std::vector<fs::path> new_study(const std::string& name, const std::string& graph, const fs::path& folder) {
  std::vector<fs::path> files = new_project(ProjectKind::study, name, folder);
  for (const fs::path& file : files) {
    write_file(file, replaced(read_input_file(file, max_example_bytes),
                              {{"[wall/scene]", "[" + nlohmann::json(graph).dump() + "]"}}));
  }
  return files;
}

}  // namespace tactor
