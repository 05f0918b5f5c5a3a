// Manual pages, in the macros of man(7).
#include <fmt/format.h>

#include <algorithm>

#include "app/verbs/reference/pages.hpp"

namespace tactor {

namespace {

/// What the foot of a page says.
struct Edition {
  std::string version, date;
};

/// A text in roff: what roff would take for a command or a dash for a hyphen is escaped; `code` is bold.
std::string roff(std::string_view text) {
  std::string out;
  bool in_code = false;
  for (const char c : text) {
    if (c == '`') {
      in_code = !in_code;
      out += in_code ? "\\fB" : "\\fR";
    } else if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if ((c == '.' || c == '\'') && out.empty()) {
      out += std::string("\\&") + c;
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '^') {
      out += "\\(ha";
    } else if (c == '~') {
      out += "\\(ti";
    } else if (c == '\n') {
      out += ' ';
    } else {
      out += c;
    }
  }
  return out;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return text;
}

/// `tactor-mesh` of the verb `mesh`; `tactor` of the command.
std::string page_name(const VerbInfo& verb) {
  return verb.name.empty() ? "tactor" : "tactor-" + verb.name;
}

std::string heading(const VerbInfo& verb, const std::string& summary, const Edition& edition) {
  return fmt::format(
      ".\\\" Made by `tactor reference --man` from declarations.\n"
      ".TH \"{}\" \"1\" \"{}\" \"Tactor {}\" \"Tactor\"\n.SH NAME\n{} \\- {}\n",
      roff(upper(page_name(verb))), edition.date, edition.version, roff(page_name(verb)), roff(summary));
}

std::string signature(const OptionInfo& option) {
  std::string text;
  for (const std::string& name : option.names) text += (text.empty() ? "" : ", ") + ("\\fB" + roff(name) + "\\fR");
  if (option.equals_sign) return text + "[=\\fI" + roff(option.value) + "\\fR]";
  if (!option.value.empty()) text += " \\fI" + roff(option.value) + "\\fR";
  return option.repeats ? text + " ..." : text;
}

std::string options(const std::vector<OptionInfo>& options) {
  std::string text;
  for (const OptionInfo& option : options) {
    std::string doc = roff(option.doc);
    if (!option.default_value.empty()) doc += " (default: " + roff(option.default_value) + ")";
    if (option.is_required) doc += " (required)";
    if (!option.needs.empty())
      doc += fmt::format("; only with {}", roff(fmt::format("{}", fmt::join(option.needs, ", "))));
    if (!option.excludes.empty()) {
      doc += fmt::format("; not with {}", roff(fmt::format("{}", fmt::join(option.excludes, ", "))));
    }
    text += ".TP\n" + signature(option) + "\n" + doc + "\n";
  }
  return text;
}

/// Usage, arguments and options, under headings of that macro.
std::string body(const VerbInfo& verb, const std::string& macro) {
  std::string text;
  if (!verb.arguments.empty()) text += macro + " Arguments\n" + options(verb.arguments);
  std::vector<std::string> groups;
  for (const OptionInfo& option : verb.options) {
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end()) groups.push_back(option.group);
  }
  for (const std::string& group : groups) {
    std::vector<OptionInfo> of_group;
    for (const OptionInfo& option : verb.options) {
      if (option.group == group) of_group.push_back(option);
    }
    text += macro + " " + roff(group) + "\n" + options(of_group);
  }
  return text;
}

std::string ending(const std::string& see_also) {
  return ".SH EXIT STATUS\n" + roff(exit_codes) + "\n.SH SEE ALSO\n" + see_also + "\n";
}

std::string verb_page(const VerbInfo& verb, const Edition& edition) {
  std::string text = heading(verb, verb.summary, edition);
  text += ".SH SYNOPSIS\n";
  if (verb.verbs.empty()) text += "\\fB" + roff(verb.usage()) + "\\fR\n";
  for (std::size_t i = 0; i < verb.verbs.size(); ++i) {
    text += (i == 0 ? "" : ".br\n") + ("\\fB" + roff(verb.verbs[i].usage()) + "\\fR\n");
  }
  text += ".SH DESCRIPTION\n" + roff(verb.summary) + ".\n" + body(verb, ".SH");
  for (const VerbInfo& inner : verb.verbs) {
    text += ".SH \"" + upper(roff(inner.name)) + "\"\n" + roff(inner.summary) + ".\n" + body(inner, ".SS");
  }
  return text + ending(".BR tactor (1)");
}

}  // namespace

Pages manual_pages(const VerbInfo& command, const std::string& version, const std::string& date) {
  const Edition edition{version, date};
  Pages pages;
  std::string verbs, see_also;
  for (const VerbInfo& verb : command.verbs) {
    pages[page_name(verb) + ".1"] = verb_page(verb, edition);
    if (verb.is_hidden) continue;
    verbs += fmt::format(".TP\n.BR {} (1)\n{}\n", roff(page_name(verb)), roff(verb.summary));
    see_also += fmt::format("{}.BR {} (1)", see_also.empty() ? "" : " ,\n", roff(page_name(verb)));
  }
  std::string summary = command.summary;
  if (summary.ends_with('.')) summary.pop_back();
  pages["tactor.1"] = heading(command, summary, edition) + ".SH SYNOPSIS\n\\fB" + roff(command.usage()) +
                      "\\fR\n.SH DESCRIPTION\n" + roff(command.summary) + "\n.SH VERBS\n" + verbs +
                      body(command, ".SH") + ending(see_also);
  return pages;
}

}  // namespace tactor
