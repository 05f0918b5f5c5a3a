#include "app/study/cluster/cluster_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <initializer_list>
#include <sstream>

#include "app/command_output.hpp"
#include "framework/core/check.hpp"
#include "framework/core/control_characters.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/kept_folder.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/core/text.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/yaml_tree.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t most_tasks_asked = 1'000'000;

const std::vector<std::string>& system_keys() {
  static const std::vector<std::string> keys{"title",     "submit",     "status", "cancel",   "index",
                                             "joined_by", "most_tasks", "states", "exclusive"};
  return keys;
}

const std::vector<std::string>& placeholders() {
  static const std::vector<std::string> names{"script",  "name",    "log",       "log_pattern", "first",   "last",
                                              "array",   "after",   "jobs",      "time",        "minutes", "partition",
                                              "account", "options", "exclusive", "at_once",     "here"};
  return names;
}

/// Calls `found` with the name in each `{name}` of the text; `${name}` is of a shell. Returns the text with what it
/// returns in their place.
template <class Found>
std::string replaced(const std::string& text, const Found& found) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text[at] == '{' ? text.find('}', at) : std::string::npos;
    const std::string name = end == std::string::npos ? std::string() : text.substr(at + 1, end - at - 1);
    const bool of_shell = at > 0 && text[at - 1] == '$';
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; };
    if (name.empty() || of_shell || !std::all_of(name.begin(), name.end(), is_letter)) {
      out += text[at++];
      continue;
    }
    out += found(name);
    at = end + 1;
  }
  return out;
}

/// Whether a program of this name or path is one of these.
bool is_one_of(const std::string& program, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), fs::path(program).filename().string()) != names.end();
}
/// Whether a program hands all of its words to a shell.
bool is_remote_shell(const std::string& program) {
  return fs::path(program).filename().string().ends_with("ssh") || is_one_of(program, {"rsh", "eval"});
}
/// Whether a program reads the word behind its `-c` as commands.
bool is_shell(const std::string& program) {
  return is_one_of(program, {"sh", "bash", "dash", "ash", "zsh", "ksh", "mksh", "csh", "tcsh", "fish", "su"});
}
/// Whether a program reads the text that it is fed as commands.
bool reads_commands(const std::string& program) {
  return is_shell(program) || is_one_of(program, {"at", "batch", "qsub", "bsub", "sbatch", "msub", "xargs"});
}

/// Whether a shell reads a word of a command; ssh hands all of its words to one.
bool is_for_shell(const CommandTemplate& command, std::size_t word) {
  if (word == 0) return false;
  if (command[word].starts_with("--wrap=") || command[word - 1] == "--wrap") return true;
  // `-c`, `-ec`, `-lc`: a text to run is the word after it.
  const std::string& before = command[word - 1];
  const bool is_text = before.starts_with('-') && !before.starts_with("--") && before.find('c') != std::string::npos;
  for (std::size_t at = 0; at < word; ++at) {
    if (is_remote_shell(command[at]) || (is_text && at + 1 < word && is_shell(command[at]))) return true;
  }
  return false;
}

/// Whether a `{name}` stands in a word for a shell where quotes of its own would not keep it in one piece: between
/// quotes, behind a backslash, or in a text that is fed to a command.
bool has_quoted_place(const std::string& word) {
  constexpr char place = '\0';
  const std::string text = replaced(word, [](const std::string&) { return std::string(1, place); });
  if (text.find(place) == std::string::npos) return false;
  if (text.find("<<") != std::string::npos) return true;
  char open = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (open != 0 && c == place) return true;
    if (c == '\\' && open != '\'') {
      if (++at < text.size() && text[at] == place) return true;
    } else if (open == 0 && (c == '\'' || c == '"' || c == '`')) {
      open = c;
    } else if (c == open) {
      open = 0;
    }
  }
  return false;
}

/// Whether a text for a shell hands words on to another one, which would read their values once more: `ssh host ...`,
/// `sh -c ...`, `--wrap=...`, `... | at now`.
bool has_inner_shell(const std::string& text) {
  std::string name, command;
  bool is_fed = false;  // by a pipe
  for (const char c : text + " ") {
    const bool ends_command = std::string_view(";&|()`\n").find(c) != std::string_view::npos;
    if (!ends_command && !std::isspace(static_cast<unsigned char>(c)) && c != '"' && c != '\'') {
      name += c;
      continue;
    }
    const bool is_option = name.starts_with('-');
    if (is_remote_shell(name) || name.starts_with("--wrap")) return true;
    if (is_option && !name.starts_with("--") && name.find('c') != std::string::npos && is_shell(command)) return true;
    if (is_fed && reads_commands(name)) return true;
    if (!name.empty()) {
      if (!is_option) command = name;
      is_fed = false;
    }
    if (ends_command) is_fed = c == '|';
    name.clear();
  }
  return false;
}

class SystemReader {
 public:
  SystemReader(ClusterSystem& system, Diagnostics& diagnostics) : system_(system), diagnostics_(diagnostics) {}

  void read(const Tree& tree) {
    check_keys(tree, "cluster", "key of a cluster file", system_keys(), diagnostics_);
    system_.title = text(tree, "title").value_or(system_.file.stem().string());
    system_.submit = command(tree, "submit", true);
    const auto has_script = [](const std::string& word) { return word.find("{script}") != std::string::npos; };
    if (!system_.submit.empty() && std::none_of(system_.submit.begin(), system_.submit.end(), has_script)) {
      diagnostics_.error(tree.value("submit")->place,
                         "submit: expected {script} in a word, which is what a task starts");
    }
    system_.status = command(tree, "status", true);
    system_.cancel = command(tree, "cancel", true);
    system_.index = text(tree, "index").value_or("");
    if (system_.index.empty()) {
      missing(tree, "index", "the variable that holds the index of a task in its array");
    }
    if (const Tree* index = tree.value("index"); !system_.index.empty() && !is_variable_name(system_.index)) {
      diagnostics_.error(index->place, "index: expected the name of a variable, of letters, digits and _, found \"" +
                                           with_visible_controls(system_.index) + "\"");
    }
    system_.joined_by = text(tree, "joined_by").value_or(":");
    system_.exclusive = text(tree, "exclusive").value_or("");
    if (const Tree* most = tree.value("most_tasks")) {
      if (most->is_sequence()) {
        system_.most_tasks = command(tree, "most_tasks", false);
      } else {
        const auto count = read_integer(*most, "most_tasks", 1, most_tasks_asked, diagnostics_);
        system_.most_tasks_of_file = static_cast<std::size_t>(count.value_or(1));
      }
    }
    const Tree* states = tree.value("states");
    if (states == nullptr) {
      missing(tree, "states", "{waiting: [...], running: [...]}");
      return;
    }
    if (!expect_map(*states, "states", "waiting and running", diagnostics_)) return;
    check_keys(*states, "states", "key", {"waiting", "running", "held"}, diagnostics_);
    system_.waiting = words(*states, "waiting", "states.waiting");
    system_.running = words(*states, "running", "states.running");
    if (states->value("held") != nullptr) system_.held = words(*states, "held", "states.held");
    // A task that is held has not ended.
    system_.waiting.insert(system_.waiting.end(), system_.held.begin(), system_.held.end());
  }

 private:
  std::optional<std::string> text(const Tree& tree, const std::string& key) {
    const Tree* value = tree.value(key);
    return value == nullptr ? std::nullopt : read_text(*value, key, diagnostics_);
  }

  void missing(const Tree& tree, const std::string& path, const std::string& what) {
    diagnostics_.error(tree.place, fmt::format("the key {} is missing: expected {}: {}", path,
                                               path.substr(path.rfind('.') + 1), what));
  }

  std::vector<std::string> words(const Tree& tree, const std::string& key, const std::string& path) {
    const Tree* value = tree.value(key);
    if (value == nullptr) {
      missing(tree, path, "a list of words");
      return {};
    }
    if (!value->is_sequence()) {
      diagnostics_.error(value->place, path + ": expected a list of words, found " + describe(*value));
      return {};
    }
    std::vector<std::string> found;
    for (const Tree& item : value->items) {
      if (!item.is_scalar()) {
        diagnostics_.error(item.place, path + ": expected a word, found " + describe(item));
        continue;
      }
      found.push_back(item.text);
    }
    return found;
  }

  CommandTemplate command(const Tree& tree, const std::string& key, bool is_needed) {
    const Tree* value = tree.value(key);
    if (value == nullptr && !is_needed) return {};
    CommandTemplate found = words(tree, key, key);
    if (value != nullptr && value->is_sequence() && value->items.empty()) {
      diagnostics_.error(value->place, key + ": expected a command as a list of words, found an empty list");
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
      replaced(found[i], [&](const std::string& name) {
        const auto& known = placeholders();
        if (std::find(known.begin(), known.end(), name) == known.end()) {
          diagnostics_.error(value->items[i].place, fmt::format("{}: expected one of {}, found {{{}}}{}", key,
                                                                list_of(known), name, did_you_mean(name, known)));
        }
        return std::string();
      });
      if (!is_for_shell(found, i)) continue;
      const auto has_place = [](const std::string& word) {
        return replaced(word, [](const std::string&) { return std::string(); }) != word;
      };
      if (has_inner_shell(found[i]) &&
          std::any_of(found.begin() + static_cast<std::ptrdiff_t>(i), found.end(), has_place)) {
        diagnostics_.error(value->items[i].place,
                           key +
                               ": expected no second shell (ssh, sh -c, eval, --wrap, a pipe into "
                               "at) in a word that a shell reads, because it reads {...} once "
                               "more; put these commands into a script and call it");
      }
      if (has_quoted_place(found[i])) {
        diagnostics_.error(value->items[i].place, key +
                                                      ": expected no quotes round {...} in a word that a shell reads, "
                                                      "because each value has its own");
      }
    }
    return found;
  }

  ClusterSystem& system_;
  Diagnostics& diagnostics_;
};

/// No file where none can be opened; reading it tells why.
ProgramsFile trusted_file(const fs::path& file) {
  if (!open_input(file).file) return {};
  try {
    return open_programs_file(file);
  } catch (const RunError& error) {
    throw InputError(fmt::format("{}; no command of the cluster file {} was run", error.what(), file.string()));
  }
}

}  // namespace

ClusterSystem load_cluster_system(const fs::path& file) {
  Diagnostics diagnostics;
  ClusterSystem system;
  system.file = fs::absolute(file);
  const ProgramsFile trusted = trusted_file(file);
  system.folder = trusted.folder;
  // The file that was looked at is read, and not one that stands there by now.
  const fs::path opened = trusted.file ? fs::path("/proc/self/fd") / std::to_string(trusted.file.number()) : file;
  const auto tree = read_yaml(opened, file.string(), {"a cluster file", "submit, status, cancel, ..."}, diagnostics);
  if (tree) SystemReader(system, diagnostics).read(*tree);
  diagnostics.throw_if_any();
  if (!trusted.file) throw InputError(file.string() + ": it was not there, and is now; no command of it was run");
  return system;
}

std::vector<std::string> filled_in(const CommandTemplate& command, const TemplateValues& values,
                                   const std::string& joined_by) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const std::string& word = command[i];
    if (word.size() > 2 && word.front() == '{' && word.back() == '}') {
      const auto list = values.lists.find(word.substr(1, word.size() - 2));
      if (list != values.lists.end()) {
        for (const std::string& one : list->second)
          words.push_back(is_for_shell(command, i) ? shell_word(one, word) : one);
        continue;
      }
    }
    bool is_whole = true;
    std::string made = replaced(word, [&](const std::string& name) -> std::string {
      std::string value;
      if (const auto text = values.texts.find(name); text != values.texts.end()) value = text->second;
      if (const auto list = values.lists.find(name); list != values.lists.end()) {
        value = fmt::format("{}", fmt::join(list->second, joined_by));
      }
      is_whole = is_whole && !value.empty();
      return is_for_shell(command, i) ? shell_word(value, "{" + name + "}") : value;
    });
    if (is_whole) words.push_back(std::move(made));
  }
  return words;
}

std::map<std::string, JobCounts> ask_for_jobs(const ClusterSystem& system, const std::vector<std::string>& jobs) {
  std::map<std::string, JobCounts> counts;
  if (jobs.empty()) return counts;
  TemplateValues values;
  values.lists["jobs"] = jobs;
  values.texts["here"] = system.folder.string();
  std::istringstream lines(output_of(filled_in(system.status, values, ",")));
  const auto is_one_of = [](const std::string& state, const std::vector<std::string>& states) {
    return std::find(states.begin(), states.end(), state) != states.end();
  };
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string job, word, state;
    words >> job;
    while (words >> word) state = word;
    if (std::find(jobs.begin(), jobs.end(), job) == jobs.end()) continue;
    if (is_one_of(state, system.waiting)) ++counts[job].waiting;
    if (is_one_of(state, system.held)) ++counts[job].held;
    if (is_one_of(state, system.running)) ++counts[job].running;
  }
  return counts;
}

void cancel_jobs(const ClusterSystem& system, const std::vector<std::string>& jobs) {
  if (jobs.empty()) return;
  TemplateValues values;
  values.lists["jobs"] = jobs;
  values.texts["here"] = system.folder.string();
  static_cast<void>(output_of(filled_in(system.cancel, values, ",")));
}

std::size_t most_tasks_of_array(const ClusterSystem& system) {
  if (system.most_tasks.empty()) return system.most_tasks_of_file;
  const std::string text(trimmed(output_of(filled_in(system.most_tasks, {}, ","))));
  std::size_t most = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), most);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size() || most == 0) {
    throw RunError(fmt::format("{}: most_tasks: expected its command to print a number of tasks, found \"{}\"",
                               system.file.string(), text));
  }
  return most;
}

}  // namespace tactor
