#include "app/verbs/option_values.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/mesh/mesh_units.hpp"
#include "framework/core/check.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

Tree scalar(const std::string& text) {
  Tree tree;
  tree.kind = text.empty() ? Tree::Kind::null : Tree::Kind::scalar;
  tree.text = text;
  return tree;
}

/// What the reader made of it; throws InputError with the first error, which names the option.
template <class T>
T value_or_throw(const std::optional<T>& value, const Diagnostics& diagnostics) {
  if (!value) throw InputError(diagnostics.list().at(0).message);
  return *value;
}

std::vector<std::string> verbs_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
  return names;
}

}  // namespace

double option_number(const std::string& option, const std::string& text, const NumberRule& rule) {
  Diagnostics diagnostics;
  return value_or_throw(read_number(scalar(text), option, rule, diagnostics), diagnostics);
}

double option_duration(const std::string& option, const std::string& text) {
  Diagnostics diagnostics;
  return value_or_throw(read_duration(scalar(text), option, true, diagnostics), diagnostics).seconds();
}

std::int64_t option_integer(const std::string& option, const std::string& text, std::int64_t min, std::int64_t max) {
  Diagnostics diagnostics;
  return value_or_throw(read_integer(scalar(text), option, min, max, diagnostics), diagnostics);
}

std::uint64_t option_seed(const std::string& option, const std::string& text) {
  Diagnostics diagnostics;
  return value_or_throw(read_seed(scalar(text), option, diagnostics), diagnostics);
}

CLI::Option* detail::add_text_option(CLI::App& verb, const std::string& name, const std::string& type,
                                     const std::string& doc, const std::function<void(const std::string&)>& take) {
  return verb.add_option_function<std::string>(name, take, doc)->type_name(type);
}

CLI::Option* choose_from(CLI::Option* option, const std::vector<std::string>& words) {
  return option->type_name(fmt::format("{}", fmt::join(words, "|")))->check(CLI::IsMember(words).description(""));
}

CLI::Option* add_mesh_unit(CLI::App& verb, std::optional<double>& scale) {
  std::vector<std::string> names;
  for (const auto& [name, metres] : mesh_units()) names.push_back(name);
  const auto take = [&scale](const std::string& word) {
    for (const auto& [name, metres] : mesh_units()) {
      if (name == word) scale = metres;
    }
  };
  return verb
      .add_option_function<std::string>("--unit", take,
                                        "The unit of the file (default: m, or mm where only that makes 20 mm to 0.5 m)")
      ->check(CLI::IsMember(names))
      ->type_name("UNIT");
}

void refuse_unknown_verb(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* at = &app;
  for (const std::string& word : words) {
    if (word.starts_with('-')) return;
    const std::vector<std::string> verbs = verbs_of(*at);
    if (verbs.empty()) return;
    if (std::find(verbs.begin(), verbs.end(), word) == verbs.end()) {
      throw InputError(fmt::format("{}: expected a verb ({}), found {}{}", at->get_name(), list_of(verbs),
                                   describe(scalar(word)), did_you_mean(word, verbs)));
    }
    at = at->get_subcommand(word);
  }
}

std::string unexpected_words(const CLI::App& app) {
  const CLI::App* verb = &app;
  while (!verb->get_subcommands().empty()) verb = verb->get_subcommands().front();
  const std::vector<std::string> words = app.remaining(true);
  std::vector<std::string> names;
  for (const CLI::Option* option : verb->get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  std::string text = fmt::format("{}: expected no more words, found {}", verb->get_name(), fmt::join(words, " "));
  for (const std::string& word : words) {
    if (!word.starts_with('-')) continue;
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("{}: expected an option of it ({}), found {}{}", verb->get_name(), list_of(names), name,
                       did_you_mean(name, names));
  }
  return text;
}

}  // namespace tactor
