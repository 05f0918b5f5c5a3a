#include "framework/yaml/diagnostics.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tactor {

namespace {

// Files keep the order in which their first error was found; inside a file errors go by line and column.
std::vector<Diagnostic> in_order(std::vector<Diagnostic> list) {
  std::vector<std::string> files;
  for (const Diagnostic& d : list) {
    if (std::find(files.begin(), files.end(), d.place.file) == files.end()) files.push_back(d.place.file);
  }
  const auto rank = [&](const Diagnostic& d) { return std::find(files.begin(), files.end(), d.place.file); };
  std::stable_sort(list.begin(), list.end(), [&](const Diagnostic& a, const Diagnostic& b) {
    if (a.place.file != b.place.file) return rank(a) < rank(b);
    if (a.place.line != b.place.line) return a.place.line < b.place.line;
    return a.place.column < b.place.column;
  });
  return list;
}

std::string join(const std::vector<Diagnostic>& list) {
  std::string text;
  for (const Diagnostic& d : list) {
    if (!text.empty()) text += '\n';
    text += d.place.text() + ": " + d.message;
  }
  return text;
}

// Edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  std::vector<std::size_t> next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        next[j] = std::min(next[j], before[j - 2] + 1);
    }
    std::swap(before, row);
    std::swap(row, next);
  }
  return row[b.size()];
}

}  // namespace

std::string SourceLocation::text() const {
  if (line <= 0) return file;
  return file + ":" + std::to_string(line) + ":" + std::to_string(column);
}

YamlError::YamlError(std::vector<Diagnostic> diagnostics)
    : InputError(join(in_order(diagnostics))), diagnostics_(in_order(std::move(diagnostics))) {}

void Diagnostics::error(const SourceLocation& place, std::string message) {
  list_.push_back({place, std::move(message)});
  if (list_.size() < most) return;
  list_.push_back({place, "there are too many errors to go on"});
  throw YamlError(std::exchange(list_, {}));
}

void Diagnostics::throw_if_any() const {
  if (any()) throw YamlError(list_);
}

std::string did_you_mean(std::string_view given, const std::vector<std::string>& names) {
  // A third of the letters may differ; texts too long for a name are not compared.
  constexpr std::size_t longest = 64;
  if (given.empty() || given.size() > longest) return {};
  std::size_t best = std::max<std::size_t>(1, (given.size() + 1) / 3) + 1;
  const std::string* nearest = nullptr;
  for (const std::string& name : names) {
    if (name.size() > longest || name == given) continue;
    const bool is_its_first_word = name.starts_with(given) && name[given.size()] == '_';
    const std::size_t distance = is_its_first_word ? 0 : edit_distance(given, name);
    if (distance < best) {
      best = distance;
      nearest = &name;
    }
  }
  return nearest == nullptr ? std::string() : "; did you mean \"" + *nearest + "\"?";
}

}  // namespace tactor
