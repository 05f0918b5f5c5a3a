#include "app/verbs/verb_info.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

namespace tactor {

namespace {

std::vector<std::string> names_of(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  for (const CLI::Option* option : options) {
    names.push_back(option->get_lnames().empty() ? option->get_name(true) : "--" + option->get_lnames()[0]);
  }
  std::sort(names.begin(), names.end());  // The set is ordered by address.
  return names;
}

OptionInfo describe_option(const CLI::Option& option) {
  OptionInfo info;
  info.doc = option.get_description();
  info.is_required = option.get_required();
  info.needs = names_of(option.get_needs());
  info.excludes = names_of(option.get_excludes());
  const bool is_flag = option.get_items_expected_max() == 0;
  if (option.get_positional()) {
    info.names = {option.get_name(true)};
  } else {
    info.group = option.get_group();
    for (const std::string& name : option.get_snames()) info.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) info.names.push_back("--" + name);
    info.equals_sign = is_flag && !option.get_fnames().empty();
  }
  if (info.equals_sign) {
    info.value = option.get_type_name();
    info.default_value = option.get_flag_value(option.get_fnames()[0], "");
  } else if (!is_flag) {
    info.value = option.get_type_name();
    info.default_value = option.get_default_str();
    info.repeats = option.get_items_expected_max() > 1;
  }
  return info;
}

VerbInfo describe_verb(const CLI::App& app, const std::string& name) {
  VerbInfo info;
  info.name = name;
  info.summary = app.get_description();
  info.is_hidden = app.get_group().empty();
  info.passes_on = app.get_prefix_command();
  for (const CLI::Option* option : app.get_options({})) {
    if (option->get_positional()) {
      info.arguments.push_back(describe_option(*option));
    } else if (!option->get_group().empty()) {
      info.options.push_back(describe_option(*option));
    }
  }
  for (const CLI::App* verb : app.get_subcommands(std::function<bool(const CLI::App*)>{})) {
    info.verbs.push_back(describe_verb(*verb, name.empty() ? verb->get_name() : name + " " + verb->get_name()));
  }
  return info;
}

}  // namespace

std::string OptionInfo::signature() const {
  std::string text = fmt::format("{}", fmt::join(names, ", "));
  if (equals_sign) return text + "[=" + value + "]";
  if (!value.empty()) text += " " + value;
  return repeats ? text + " ..." : text;
}

std::string VerbInfo::usage() const {
  std::string text = name.empty() ? "tactor" : "tactor " + name;
  if (!options.empty()) text += " [OPTIONS]";
  for (const OptionInfo& argument : arguments) {
    const std::string word = argument.repeats ? argument.names[0] + "..." : argument.names[0];
    text += argument.is_required ? " " + word : " [" + word + "]";
  }
  if (!verbs.empty()) text += " VERB ...";
  if (passes_on) text += " [WORDS...]";
  return text;
}

const VerbInfo* VerbInfo::verb(std::string_view word) const {
  for (const VerbInfo& info : verbs) {
    const std::size_t space = info.name.rfind(' ');
    if (std::string_view(info.name).substr(space == std::string::npos ? 0 : space + 1) == word) return &info;
  }
  return nullptr;
}

VerbInfo describe_verbs(const CLI::App& app) {
  return describe_verb(app, "");
}

}  // namespace tactor
