// `tactor complete`: what may follow on a command line, for the shells.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/verbs/named_graphs.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verb_info.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/control_characters.hpp"
#include "framework/core/file_lookup.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

namespace fs = std::filesystem;

/// What may stand in a place of the command line.
struct Candidates {
  struct Word {
    std::string text, meaning;
  };
  std::vector<Word> words;
  bool files = false, folders = false;
};

/// The names of the files of that kind, without the ending that a name may leave out.
std::vector<std::string> names_of_files(const FileKind& kind) {
  std::vector<std::string> names;
  for (const fs::path& file : files_of(kind)) names.push_back(file.stem().string());
  return names;
}

std::vector<std::string> graph_names() {
  std::vector<std::string> names;
  for (const NamedGraph& graph : graphs_by_name(graph_files)) {
    if (!is_below(graph, method_files.part) && !is_below(graph, study_files.part)) names.push_back(graph.name);
  }
  return names;
}

void add_words(const std::vector<std::string>& words, Candidates& found) {
  for (const std::string& word : words) found.words.push_back({word, {}});
}

void add_node_types(Candidates& found) {
  Registry registry(default_node_folders());
  registry.load_all();
  for (const NodeInfo* info : registry.types()) found.words.push_back({info->type, info->summary});
}

void add_message_types(Candidates& found) {
  Registry registry(default_node_folders());
  registry.load_all();
  for (const auto& [name, type] : registry.message_types()) found.words.push_back({name, {}});
}

void add_meshes(Candidates& found) {
  FileKind kind = mesh_files;
  for (const char* ending : {".off", ".obj", ".stl", ".ply"}) {
    kind.ending = ending;
    for (const fs::path& file : files_of(kind)) found.words.push_back({file.filename().string(), {}});
  }
  found.files = true;
}

/// What a value of one kind of value_types.hpp may be.
void add_values_of(const std::string& kind, Candidates& found) {
  if (kind == value_type::folder || kind == value_type::results) found.folders = true;
  if (kind == value_type::results || kind == value_type::file || kind == value_type::recording) found.files = true;
  if (kind == value_type::mesh) add_meshes(found);
  if (kind == value_type::node_type) add_node_types(found);
  if (kind == value_type::message_type) add_message_types(found);
  if (kind == value_type::graph) add_words(graph_names(), found), found.files = true;
  if (kind == value_type::study) add_words(names_of_files(study_files), found), found.files = true;
  if (kind == value_type::method) add_words(names_of_files(method_files), found), found.files = true;
  const bool is_word = std::none_of(kind.begin(), kind.end(), [](char c) { return c < 'a' || c > 'z'; });
  if (is_word && !kind.empty()) found.words.push_back({kind, {}});
}

void add_values(const std::string& type, Candidates& found) {
  for (std::size_t begin = 0; begin <= type.size();) {
    const std::size_t end = std::min(type.find('|', begin), type.size());
    add_values_of(type.substr(begin, end - begin), found);
    begin = end + 1;
  }
}

const OptionInfo* option_of(const VerbInfo& verb, const std::string& name) {
  for (const OptionInfo& option : verb.options) {
    if (std::find(option.names.begin(), option.names.end(), name) != option.names.end()) return &option;
  }
  return nullptr;
}

/// Candidates for the last of `words`, which may be empty.
Candidates candidates(const VerbInfo& command, const std::vector<std::string>& words) {
  Candidates found;
  const VerbInfo* verb = &command;
  std::size_t arguments = 0;
  const OptionInfo* open = nullptr;  // an option whose value the next word is
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string& word = words[i];
    if (open != nullptr) {
      open = nullptr;
    } else if (word.starts_with('-')) {
      const OptionInfo* option = option_of(*verb, word);
      if (option != nullptr && !option->value.empty() && !option->equals_sign) open = option;
    } else if (const VerbInfo* inner = verb->verb(word)) {
      verb = inner;
    } else {
      ++arguments;
    }
  }
  const std::string word = words.empty() ? "" : words.back();
  if (open != nullptr) {
    add_values(open->value, found);
  } else if (const std::size_t equals = word.find('='); word.starts_with("--") && equals != std::string::npos) {
    const OptionInfo* option = option_of(*verb, word.substr(0, equals));
    if (option != nullptr) add_values(option->value, found);
    for (Candidates::Word& one : found.words) one.text.insert(0, word.substr(0, equals + 1));
    found.files = found.folders = false;
  } else if (word.starts_with('-')) {
    for (const OptionInfo& option : verb->options) found.words.push_back({option.names.back(), option.doc});
  } else if (!verb->verbs.empty()) {
    for (const VerbInfo& inner : verb->verbs) {
      if (!inner.is_hidden) found.words.push_back({inner.name.substr(inner.name.rfind(' ') + 1), inner.summary});
    }
  } else if (!verb->arguments.empty()) {
    const OptionInfo& last = verb->arguments.back();
    if (arguments < verb->arguments.size()) add_values(verb->arguments[arguments].value, found);
    if (arguments >= verb->arguments.size() && last.repeats) add_values(last.value, found);
    if (arguments >= verb->arguments.size() && verb->passes_on) found.files = true;
  }
  std::erase_if(found.words, [&](const Candidates::Word& one) { return !one.text.starts_with(word); });
  return found;
}

void print(const Candidates& found) {
  for (const Candidates::Word& word : found.words) {
    // The shells read a line each: of a file's name with a line break they would offer the halves.
    if (!has_control_characters(word.text)) fmt::print("{}\t{}\n", word.text, word.meaning);
  }
  if (found.files) fmt::print(":files\n");
  if (found.folders) fmt::print(":folders\n");
}

}  // namespace

void add_complete(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("complete",
                                      "Print what may follow on a command line, for completion in a shell: a line "
                                      "`WORD<tab>MEANING` each; `:files` and "
                                      "`:folders` where these fit too");
  verb->group("");
  const auto words = std::make_shared<std::vector<std::string>>();
  verb->add_option("words", *words, "The words behind `tactor`, after `--`; the last one is completed")
      ->type_name("WORD");
  verb->callback([&app, words, &exit_code] {
    print(candidates(describe_verbs(app), *words));
    exit_code = 0;
  });
}

}  // namespace tactor
