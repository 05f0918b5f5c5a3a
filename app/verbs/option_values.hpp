// Options of the command line whose values are read as those of a graph file are, and told alike where they are wrong.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "framework/yaml/yaml_values.hpp"

namespace tactor {

/// The value behind an option, by the readers of graph files. Each throws InputError with the option, what was expected
/// and what was found.
double option_number(const std::string& option, const std::string& text, const NumberRule& rule);
/// A time of at least 1 ns and at most longest_time_s, in s.
double option_duration(const std::string& option, const std::string& text);
std::int64_t option_integer(const std::string& option, const std::string& text, std::int64_t min, std::int64_t max);
std::uint64_t option_seed(const std::string& option, const std::string& text);

namespace detail {
CLI::Option* add_text_option(CLI::App& verb, const std::string& name, const std::string& type, const std::string& doc,
                             const std::function<void(const std::string&)>& take);
}

/// Adds the option `name` (`--duration`) with a value of that kind. `Target` is the number or an optional of it; the
/// help shows no default, which `doc` may tell or the caller set by default_str().
template <class Target>
CLI::Option* add_number(CLI::App& verb, const std::string& name, Target& target, const NumberRule& rule,
                        const std::string& doc) {
  return detail::add_text_option(
      verb, name, rule.unit == "1" ? "NUMBER" : rule.unit, doc,
      [&target, name, rule](const std::string& text) { target = option_number(name, text, rule); });
}

template <class Target>
CLI::Option* add_duration(CLI::App& verb, const std::string& name, Target& target, const std::string& doc) {
  return detail::add_text_option(verb, name, "TIME", doc,
                                 [&target, name](const std::string& text) { target = option_duration(name, text); });
}

template <class Target>
CLI::Option* add_integer(CLI::App& verb, const std::string& name, Target& target, std::int64_t min, std::int64_t max,
                         const std::string& doc) {
  const std::string type = "COUNT in [" + std::to_string(min) + " - " + std::to_string(max) + "]";
  return detail::add_text_option(verb, name, type, doc, [&target, name, min, max](const std::string& text) {
    target = option_integer(name, text, min, max);
  });
}

template <class Target>
CLI::Option* add_seed(CLI::App& verb, const std::string& name, Target& target, const std::string& doc) {
  return detail::add_text_option(verb, name, "SEED", doc,
                                 [&target, name](const std::string& text) { target = option_seed(name, text); });
}

/// Lets the option take one of `words` alone, which help, reference and completion then show.
CLI::Option* choose_from(CLI::Option* option, const std::vector<std::string>& words);

/// Adds `--unit`, of a mesh file; `scale` becomes what one unit of the file is in m.
CLI::Option* add_mesh_unit(CLI::App& verb, std::optional<double>& scale);

/// Throws InputError where the first word of `words` (without the program's name) that is no option names no verb of
/// `app`, or the word after a verb with verbs of its own none of those; the message lists them and names the nearest.
void refuse_unknown_verb(const CLI::App& app, const std::vector<std::string>& words);

/// What is wrong with words that no option and no argument took: the option that the user may have meant, or the words.
std::string unexpected_words(const CLI::App& app);

}  // namespace tactor
