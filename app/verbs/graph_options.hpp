// Options that several verbs share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "app/results_folder.hpp"
#include "app/verbs/value_types.hpp"
#include "framework/graph/spec.hpp"

namespace CLI {
class App;
}

namespace tactor {

class Registry;

/// What the command line lays over a graph: --over, --set, --seed, --duration, in the order in which they stand there.
struct GraphOptions {
  Overrides overrides;

  /// `verb` calls back into this object while it parses.
  void add_to(CLI::App& verb, bool with_seed);
};

/// The graph of that path or name (see find_file) with these options laid over it.
GraphSpec load(const std::filesystem::path& graph, Registry& registry, const GraphOptions& options);

/// Loads every node library there is, and tells on standard error which cannot be used and why.
void load_all_libraries(Registry& registry);

/// --out and --overwrite; `doc` tells the default of --out, `type` what it names.
void add_results(CLI::App& verb, ResultsRequest& results, const std::string& doc,
                 const char* type = value_type::folder);

// Beyond these nobody means what was typed.
inline constexpr std::int64_t most_seeds = 10'000;
inline constexpr std::int64_t most_jobs = 1024;

/// --no-dead-man, for verbs that drive hardware.
void add_no_dead_man(CLI::App& verb, bool& accepted);

/// The cores of this machine, at least 1: how many runs are made at once unless the user says otherwise.
unsigned cores();

}  // namespace tactor
