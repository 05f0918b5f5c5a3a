// A page a verb, with the verbs of its own.
#include <fmt/format.h>

#include <algorithm>

#include "app/verbs/reference/pages.hpp"

namespace tactor {

namespace {

std::string page_of(const VerbInfo& verb) {
  return "verbs/" + verb.name + ".md";
}

std::string joined_code(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + code_span(name);
  return text;
}

/// What an option means, and with which others it goes.
std::string option_text(const OptionInfo& option, const PageWriter& page) {
  std::string text = page.text(option.doc);
  if (!option.needs.empty()) text += "; only with " + joined_code(option.needs);
  if (!option.excludes.empty()) text += "; not with " + joined_code(option.excludes);
  return text;
}

void add_options(const std::vector<OptionInfo>& options, const std::string& head, PageWriter& page) {
  std::vector<std::vector<std::string>> rows;
  for (const OptionInfo& option : options) {
    rows.push_back({code_span(option.signature()), option.is_required ? "required" : code_span(option.default_value),
                    option_text(option, page)});
  }
  page.table({head, "default", "meaning"}, rows);
}

/// The options of one group after the other, in the order in which the groups begin.
void add_option_groups(const VerbInfo& verb, int level, PageWriter& page) {
  std::vector<std::string> groups;
  for (const OptionInfo& option : verb.options) {
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end()) groups.push_back(option.group);
  }
  for (const std::string& group : groups) {
    std::vector<OptionInfo> options;
    for (const OptionInfo& option : verb.options) {
      if (option.group == group) options.push_back(option);
    }
    page.heading(level, group);
    add_options(options, "option", page);
  }
}

void add_verb(const VerbInfo& verb, int level, PageWriter& page) {
  page.code("text", verb.usage() + "\n");
  if (!verb.arguments.empty()) page.heading(level, "Arguments");
  add_options(verb.arguments, "argument", page);
  add_option_groups(verb, level, page);
}

void add_verb_page(const VerbInfo& verb, const ReferenceSource& source, Pages& pages) {
  PageWriter page(page_of(verb), "tactor " + verb.name, source.types);
  page.prose(verb.summary + ".");
  add_verb(verb, 2, page);
  for (const VerbInfo& inner : verb.verbs) {
    page.heading(2, "tactor " + inner.name);
    page.prose(inner.summary + ".");
    add_verb(inner, 3, page);
  }
  page.heading(2, "Exit codes");
  page.prose(exit_codes);
  page.put_into(pages);
}

}  // namespace

void add_verb_pages(const ReferenceSource& source, Pages& pages) {
  PageWriter index("verbs.md", "Verbs of the command", source.types);
  index.prose("Find the verb of `tactor` for what you want to do; its page has arguments, options and defaults.");
  index.code("sh", "tactor --help\ntactor run --help\n");
  std::vector<std::vector<std::string>> rows, hidden;
  for (const VerbInfo& verb : source.command.verbs) {
    (verb.is_hidden ? hidden : rows)
        .push_back({index.link("tactor " + verb.name, page_of(verb)), index.text(verb.summary)});
    add_verb_page(verb, source, pages);
  }
  index.table({"verb", "what it does"}, rows);
  index.heading(2, "Verbs for scripts");
  index.prose("The overview of `tactor --help` leaves these out.");
  index.table({"verb", "what it does"}, hidden);
  index.heading(2, "Options of the command");
  add_options(source.command.options, "option", index);
  index.heading(2, "Exit codes");
  index.prose(exit_codes);
  index.put_into(pages);
}

}  // namespace tactor
