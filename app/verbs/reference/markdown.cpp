#include "app/verbs/reference/markdown.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "framework/graph/text_table.hpp"

namespace tactor {

namespace {

constexpr std::size_t page_columns = 120;

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// What Markdown could take for a mark inside of a line. An underscore inside of a word is not a mark.
bool is_mark(std::string_view text, std::size_t at) {
  const char c = text[at];
  if (c == '_') return at == 0 || at + 1 == text.size() || !is_word(text[at - 1]) || !is_word(text[at + 1]);
  // A tag begins with a letter or a mark, a comparison does not.
  if (c == '<') return at + 1 < text.size() && (is_word(text[at + 1]) || text[at + 1] == '/' || text[at + 1] == '!');
  return std::string_view("\\*[]$|").find(c) != std::string_view::npos || text.substr(at, 2) == "~~";
}

/// A word that would begin a list, a heading or a quotation where it begins a line.
bool begins_block(std::string_view word) {
  if (word == "-" || word == "+" || word == "=" || word.starts_with(">") || word.starts_with("---") ||
      word.starts_with("==="))
    return true;
  if (!word.empty() && word.find_first_not_of('#') == std::string_view::npos) return true;
  const std::size_t digits = word.find_first_not_of("0123456789");
  return digits != 0 && digits != std::string_view::npos && digits + 1 == word.size() &&
         (word[digits] == '.' || word[digits] == ')');
}

std::string escaped_beginning(std::string_view word) {
  if (!begins_block(word)) return std::string(word);
  const std::size_t at = word.size() - 1;
  if (word[at] == '.' || word[at] == ')') return std::string(word.substr(0, at)) + "\\" + word[at];
  return "\\" + std::string(word);
}

/// The words of a text, between spaces; a link or a span of code is kept together.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words(1);
  bool in_code = false, in_link = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool is_escaped = i > 0 && text[i - 1] == '\\' && !in_code;
    if (c == '`') in_code = !in_code;
    if (c == '[' && !in_code && !is_escaped) in_link = true;
    if (c == ')' && in_link && !in_code) in_link = false;
    if ((c == ' ' || c == '\n') && !in_code && !in_link) {
      if (!words.back().empty()) words.emplace_back();
    } else {
      words.back() += c == '\n' ? ' ' : c;
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

/// `mark` begins the first line, and the others are indented as far.
std::string folded(std::string_view paragraph, std::string_view mark = "") {
  std::string out, line;
  for (const std::string& word : words_of(paragraph)) {
    if (!line.empty() && display_width(line) + 1 + display_width(word) > page_columns) {
      out += line + "\n";
      line.clear();
    }
    line += line.empty() ? (out.empty() ? std::string(mark) : std::string(mark.size(), ' ')) + escaped_beginning(word)
                         : " " + word;
  }
  return out + line + "\n";
}

/// Also inside of code a bar ends the cell of a table.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' && !out.ends_with('\\')) out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

}  // namespace

PageWriter::PageWriter(std::string path, std::string title, const std::set<std::string>& types)
    : path_(std::move(path)), types_(types) {
  page_ = "# " + text(title) + "\n\n<!-- Made by `tactor reference` from declarations; do not edit. -->\n";
}

void PageWriter::heading(int level, std::string_view text) {
  page_ += "\n" + std::string(static_cast<std::size_t>(level), '#') + " " + std::string(text) + "\n";
}

void PageWriter::prose(std::string_view plain) {
  for (std::size_t begin = 0; begin < plain.size();) {
    const std::size_t end = std::min(plain.find("\n\n", begin), plain.size());
    markdown(text(plain.substr(begin, end - begin)));
    begin = end + 2;
  }
}

void PageWriter::markdown(std::string_view text) {
  page_ += "\n" + folded(text);
}

void PageWriter::code(std::string_view language, std::string_view text) {
  page_ += fmt::format("\n```{}\n{}```\n", language, text);
}

void PageWriter::table(const std::vector<std::string>& heads, const std::vector<std::vector<std::string>>& rows) {
  if (rows.empty()) return;
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    if (std::any_of(rows.begin(), rows.end(), [i](const auto& row) { return !row[i].empty(); })) shown.push_back(i);
  }
  std::string head = "\n|", rule = "|";
  for (const std::size_t i : shown) {
    head += " " + heads[i] + " |";
    rule += "---|";
  }
  page_ += head + "\n" + rule + "\n";
  for (const std::vector<std::string>& row : rows) {
    page_ += "|";
    for (const std::size_t i : shown) page_ += row[i].empty() ? " |" : " " + cell(row[i]) + " |";
    page_ += "\n";
  }
}

void PageWriter::list(const std::vector<std::string>& items) {
  if (!items.empty()) page_ += "\n";
  for (const std::string& item : items) page_ += folded(item, "- ");
}

std::string PageWriter::text(std::string_view plain) const {
  std::string out;
  for (std::size_t i = 0; i < plain.size();) {
    const char c = plain[i];
    const std::size_t closing = c == '`' ? plain.find('`', i + 1) : std::string_view::npos;
    if (closing != std::string_view::npos) {
      out += code_span(plain.substr(i + 1, closing - i - 1));
      i = closing + 1;
      continue;
    }
    if (is_word(c) && (i == 0 || !is_word(plain[i - 1]))) {
      std::size_t end = i;
      while (end < plain.size() && (is_word(plain[end]) || plain[end] == '/' || plain[end] == '.')) ++end;
      while (end > i && !is_word(plain[end - 1])) --end;
      const std::string word(plain.substr(i, end - i));
      const bool is_page = word.starts_with("docs/") && word.ends_with(".md");
      const std::string own = "nodes/" + word + ".md";
      if (is_page || (types_.count(word) > 0 && own != path_)) {
        out += link(word, is_page ? "../" + word.substr(5) : own);
        i = end;
        continue;
      }
    }
    if (is_mark(plain, i)) out += '\\';
    out += c;
    ++i;
  }
  return out;
}

std::string PageWriter::link(std::string_view shown, const std::string& to) const {
  return fmt::format("[{}]({})", shown, path_to(to));
}

std::string PageWriter::path_to(const std::string& to) const {
  const std::size_t hash = std::min(to.find('#'), to.size());
  // The folder of the reference has two above it, which `..` at the beginning of `to` may name.
  const std::filesystem::path root = "/repository/docs/reference";
  const std::filesystem::path target = (root / to.substr(0, hash)).lexically_normal();
  const std::filesystem::path here = (root / path_).lexically_normal();
  const std::string way = target == here ? "" : target.lexically_relative(here.parent_path()).generic_string();
  return way + to.substr(hash);
}

void PageWriter::put_into(Pages& pages) const {
  pages[path_] = page_;
}

std::string code_span(std::string_view text) {
  return text.empty() ? "" : "`" + std::string(text) + "`";
}

std::string anchor_of(std::string_view heading) {
  std::string anchor;
  for (const char c : heading) {
    if (c == ' ') anchor += '-';
    if (is_word(c) || c == '-') anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return anchor;
}

}  // namespace tactor
