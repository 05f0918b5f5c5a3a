#include "app/bundle/bundle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>

#include "app/bundle/shared_libraries.hpp"
#include "app/command_output.hpp"
#include "app/output.hpp"
#include "app/run/build_info.hpp"
#include "app/run/recorded_reference.hpp"
#include "app/run/references.hpp"
#include "app/study/prepare_study.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/installation.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/engine/reference.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// What studies in virtual time never load.
constexpr std::array<std::string_view, 3> of_live_runs{"libtactor_live.so", "libtactor_view.so", "libtactor_python.so"};

/// The command of a bundle whose libraries are in this folder of it.
std::string command_text(const std::string& libraries) {
  return "#!/bin/sh\n"
         "# Tactor with the libraries beside it.\n"
         "self=$0\n"
         "[ ! -h \"$0\" ] || self=$(readlink -f -- \"$0\") || exit 1\n"
         "here=$(CDPATH= cd -- \"$(dirname -- \"$self\")\" && pwd) || exit 1\n"
         "case $here in\n"
         "  *:* | *\\;*) echo \"$here: expected a folder without : and ;, which end a name in lists of folders; move "
         "it\" "
         ">&2; exit 2 ;;\n"
         "esac\n"
         "libraries=" +
         shell_word(libraries, "the folder of the libraries") +
         "\n"
         "TACTOR_OUTER_LD_LIBRARY_PATH=${LD_LIBRARY_PATH-}\n"
         "LD_LIBRARY_PATH=$here/$libraries:$here/system_lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}\n"
         "export LD_LIBRARY_PATH TACTOR_OUTER_LD_LIBRARY_PATH\n"
         "exec \"$here/bin/tactor\" \"$@\"\n";
}

bool is_inside(const fs::path& file, const fs::path& folder) {
  const auto [of_file, of_folder] = std::mismatch(file.begin(), file.end(), folder.begin(), folder.end());
  return of_folder == folder.end();
}

/// Python, with what its nodes import, is the other machine's own.
void refuse_python(const Plan& plan, const fs::path& study) {
  for (const NodeSpec& node : plan.nodes) {
    if (node.info->code.empty()) continue;
    throw InputError(
        fmt::format("{}: expected nodes in C++, found {}, which is in Python: install tactor with Python on the "
                    "other machine",
                    study.string(), node.info->type));
  }
}

/// Reads all that the runs of a study read.
void read_study(const fs::path& file, bool is_short, Registry& registry) {
  // Where its results would go does not matter, and must not.
  const PreparedStudy study = prepare_study({.file = file, .out = fs::path("/nowhere"), .is_short = is_short});
  for (const RunCase& c : study.cases) {
    for (const std::uint64_t seed : study.settings.seeds) {
      if (c.reference_recording.empty()) break;
      static_cast<void>(open_input_file(recording_of(c.reference_recording, graph_name(c.graph), seed)));
    }
    std::vector<Overrides> all{c.overrides};
    if (c.reference) all.push_back(*c.reference);
    for (const Overrides& overrides : all) {
      try {
        // The key of a run is over the bytes of all files that it reads.
        const Plan plan = make_plan(load_graph(c.graph, registry, overrides));
        refuse_python(plan, file);
        static_cast<void>(reference_key(plan, {}));
      } catch (const InputError&) {
        if (!study.settings.refused_are_results) throw;
      }
    }
  }
}

/// The files that a study reads: its own, and those of its graphs. Loads the node libraries that it needs.
std::set<fs::path> inputs_of_study(const fs::path& file) {
  const InputLog log;
  Registry registry(default_node_folders());
  read_study(file, false, registry);
  try {
    read_study(file, true, registry);
  } catch (const InputError&) {
    // It says nothing under `short`, since what it says there has been checked above.
  }
  return log.files();
}

fs::path common_folder(const std::set<fs::path>& files) {
  fs::path common = files.begin()->parent_path();
  for (const fs::path& file : files) {
    while (!is_inside(file, common)) common = common.parent_path();
  }
  return common;
}

/// A folder that becomes the archive.
class Stage {
 public:
  explicit Stage(fs::path folder) : folder_(std::move(folder)), prefix_(fs::canonical(installation_prefix())) {}

  void add(const fs::path& file, const fs::path& to) const {
    const fs::path target = folder_ / to;
    fs::create_directories(target.parent_path());
    fs::copy_file(file, target, fs::copy_options::skip_existing);
  }

  /// The program, with the plugins and nodes that are loaded now; those of other folders go to its nodes.
  void add_program() {
    add_binary(fs::read_symlink("/proc/self/exe"), "bin/tactor");
    for (const fs::path& file : code_files()) {
      const std::string name = file.filename().string();
      const bool is_program = name == "tactor" || name.find(".so.") != std::string::npos;
      if (is_program || std::find(of_live_runs.begin(), of_live_runs.end(), name) != of_live_runs.end()) continue;
      add_binary(
          file, is_inside(file, prefix_) ? place_in_prefix(file) : place_in_prefix(library_folder()) / "tactor" / name);
    }
    if (const fs::path build = library_folder() / "tactor/plugins" / build_library_file; fs::exists(build)) {
      add_binary(build, place_in_prefix(build));
    }
    for (const fs::path& folder : {prefix_ / "clusters", prefix_ / "share/tactor/clusters"}) {
      if (!fs::exists(folder)) continue;
      for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) add(entry.path(), "clusters" / fs::relative(entry.path(), folder));
      }
    }
    write_file(folder_ / "tactor", command_text(place_in_prefix(library_folder()).string()));
    fs::permissions(folder_ / "tactor", fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                    fs::perm_options::add);
  }

  /// Libraries that all these need: under the names that the loader looks for, which may be those of links.
  void add_libraries() const {
    for (const fs::path& file : shared_libraries(binaries_)) {
      const fs::path folder = fs::canonical(file.parent_path());
      add(fs::canonical(file),
          (is_inside(folder, prefix_) ? place_in_prefix(folder) : fs::path("system_lib")) / file.filename());
    }
  }

  /// The studies, and what they read: below the prefix as it is there, all else below `files`.
  void add_inputs(const std::set<fs::path>& inputs) const {
    std::set<fs::path> own;
    for (const fs::path& file : inputs) {
      if (is_inside(file, prefix_)) {
        add(file, place_in_prefix(file));
      } else {
        own.insert(file);
      }
    }
    if (own.empty()) return;
    const fs::path common = common_folder(own);
    for (const fs::path& file : own) add(file, "files" / fs::relative(file, common));
  }

  [[nodiscard]] fs::path place_in_prefix(const fs::path& file) const { return fs::relative(file, prefix_); }
  [[nodiscard]] const fs::path& folder() const { return folder_; }
  [[nodiscard]] const fs::path& prefix() const { return prefix_; }

 private:
  void add_binary(const fs::path& file, const fs::path& to) {
    add(file, to);
    binaries_.push_back(file);
  }

  fs::path folder_, prefix_;
  std::vector<fs::path> binaries_;
};

/// Where a study file is in the bundle. Throws InputError where what it reads there is still somewhere else.
fs::path checked_copy(const Stage& stage, const fs::path& study, const std::set<fs::path>& inputs) {
  std::set<fs::path> own;
  for (const fs::path& file : inputs) {
    if (!is_inside(file, stage.prefix())) own.insert(file);
  }
  const fs::path whole = fs::canonical(study);
  const fs::path copy = is_inside(whole, stage.prefix())
                            ? stage.folder() / stage.place_in_prefix(whole)
                            : stage.folder() / "files" / fs::relative(whole, common_folder(own));
  for (const fs::path& file : inputs_of_study(copy)) {
    if (is_inside(file, stage.folder()) || is_inside(file, stage.prefix())) continue;
    throw InputError(
        fmt::format("{}: expected files with paths relative to the file that names them, found {}, which does not "
                    "exist on another machine",
                    study.string(), file.string()));
  }
  return fs::relative(copy, stage.folder());
}

}  // namespace

void write_bundle(const BundleRequest& request) {
  std::error_code ignored;
  refuse_control_characters(request.out.string(), "--out");
  const std::string ending = ".tar.gz";
  const std::string file = request.out.filename().string();
  if (!file.ends_with(ending) || file.size() == ending.size()) {
    throw InputError(fmt::format("--out {}: expected a name that ends in {}", request.out.string(), ending));
  }
  if (fs::exists(request.out, ignored) && !request.overwrite) {
    throw InputError(
        fmt::format("--out {}: expected no file there yet; --overwrite replaces it", request.out.string()));
  }
  if (!fs::is_directory(fs::absolute(request.out).parent_path())) {
    throw InputError(fmt::format("--out {}: expected a folder that exists", request.out.string()));
  }
  const std::string name = file.substr(0, file.size() - ending.size());
  const TemporaryFolder temporary;
  Stage stage(fs::canonical(temporary.path()) / name);
  fs::create_directories(stage.folder());
  std::set<fs::path> inputs;
  for (const fs::path& study : request.studies) inputs.merge(inputs_of_study(study));
  stage.add_program();
  stage.add_libraries();
  stage.add_inputs(inputs);
  std::vector<fs::path> copies;
  for (const fs::path& study : request.studies) copies.push_back(checked_copy(stage, study, inputs));
  // The same bytes for the same files, whenever and by whomever it is made.
  static_cast<void>(output_of({"tar", "--create", "--gzip", "--file", fs::absolute(request.out).string(), "--directory",
                               stage.folder().parent_path().string(), "--sort=name", "--mtime=@0", "--owner=0",
                               "--group=0", "--numeric-owner", "--", name}));
  fmt::print("{}: {:.0f} MB; on the other machine:\n  tar xf {} && cd {}\n", request.out.string(),
             static_cast<double>(fs::file_size(request.out)) / 1e6, as_typed(file), as_typed(name));
  for (const fs::path& copy : copies)
    fmt::print("  ./tactor study {} --cluster slurm --partition NAME\n", as_typed(copy.string()));
}

}  // namespace tactor
