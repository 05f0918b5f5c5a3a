// Errors of a YAML file: collected with their places, so that one load names all of them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/check.hpp"

namespace tactor {

/// A place in a file; line and column count from 1. A line of 0 means the file as a whole (or the command line).
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;
  [[nodiscard]] std::string text() const;  ///< `file:line:column`, `file`
};

/// One error.
struct Diagnostic {
  SourceLocation place;
  std::string message;
};

/// A file (a graph, a profile) cannot be used. what() holds one line for each error, `file:line:col: message`, in order
/// of the file.
class YamlError : public InputError {
 public:
  explicit YamlError(std::vector<Diagnostic> diagnostics);
  [[nodiscard]] const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// Collects errors of a load.
class Diagnostics {
 public:
  /// More errors than anybody reads; each may be compared with every name of the file.
  static constexpr std::size_t most = 200;

  /// Throws YamlError with all that were collected if there are too many of them.
  void error(const SourceLocation& place, std::string message);
  /// Takes over the errors of another file.
  void add(const YamlError& error) {
    list_.insert(list_.end(), error.diagnostics().begin(), error.diagnostics().end());
  }
  [[nodiscard]] bool any() const { return !list_.empty(); }
  [[nodiscard]] const std::vector<Diagnostic>& list() const { return list_; }
  /// Throws YamlError if there was any error.
  void throw_if_any() const;

 private:
  std::vector<Diagnostic> list_;
};

/// The name whose first word is `given` (`k_0` for `k`), else that nearest to it by edit distance, as `; did you mean
/// "x"?`, or empty where none is near.
std::string did_you_mean(std::string_view given, const std::vector<std::string>& names);

}  // namespace tactor
