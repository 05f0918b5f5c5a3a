// The verbs of the command as data, read from the declarations of the command line: for the reference, manual pages and
// completion.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace tactor {

/// What every verb returns, unless its own text says otherwise.
inline constexpr std::string_view exit_codes = "0 done, 1 failed while running, 2 bad input.";

/// An option or argument of a verb.
struct OptionInfo {
  std::vector<std::string> names;  ///< `-h`, `--help`; of an argument its name alone
  std::string group;               ///< `Options`, `Cluster`; empty for arguments
  std::string value;               ///< what it takes (see value_types.hpp); empty: nothing
  std::string default_value;       ///< empty: none, or told by `doc`
  std::string doc;
  std::vector<std::string> needs;     ///< options that must be given too
  std::vector<std::string> excludes;  ///< options that must not
  bool is_required = false;
  bool repeats = false;      ///< it takes several values
  bool equals_sign = false;  ///< the value is optional and must follow `=`

  /// `--jobs COUNT`, `-h, --help`.
  [[nodiscard]] std::string signature() const;
};

/// A verb, or the command itself.
struct VerbInfo {
  std::string name;  ///< `mesh check`; empty: the command
  std::string summary;
  bool is_hidden = false;  ///< the overview of the command leaves it out
  bool passes_on = false;  ///< what follows it goes to another program
  std::vector<OptionInfo> arguments;
  std::vector<OptionInfo> options;
  std::vector<VerbInfo> verbs;  ///< of its own

  /// `tactor mesh check [OPTIONS] file`.
  [[nodiscard]] std::string usage() const;
  /// The verb of that word; null if there is no such verb.
  [[nodiscard]] const VerbInfo* verb(std::string_view word) const;
};

/// The command with all its verbs.
VerbInfo describe_verbs(const CLI::App& app);

}  // namespace tactor
