#include "app/run/provenance.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <link.h>

#include <ctime>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "app/run/build_info.hpp"
#include "app/run/sha256.hpp"
#include "framework/core/check.hpp"
#include "framework/core/shown_text.hpp"

namespace tactor {

namespace fs = std::filesystem;

using ProvenanceJson = nlohmann::ordered_json;

namespace {

/// Now, UTC: `2026-11-26T11:45:57Z`.
std::string this_second() {
  return fmt::format("{:%FT%TZ}", fmt::gmtime(std::time(nullptr)));
}

ProvenanceJson files_json(const std::vector<HashedFile>& files) {
  ProvenanceJson list = ProvenanceJson::array();
  for (const HashedFile& one : files) {
    ProvenanceJson json;
    if (!one.of.empty()) json["of"] = one.of;
    json["file"] = shown_text(one.file.string());
    json["sha256"] = one.sha256;
    list.push_back(std::move(json));
  }
  return list;
}

std::vector<HashedFile> files_from_json(const ProvenanceJson& list) {
  std::vector<HashedFile> files;
  for (const ProvenanceJson& one : list) {
    files.push_back({one.value("of", ""), one.at("file").get<std::string>(), one.at("sha256").get<std::string>()});
  }
  return files;
}

}  // namespace

std::vector<InputOfPlan> input_files(const Plan& plan) {
  std::vector<InputOfPlan> inputs;
  for (const fs::path& file : plan.graph.files) inputs.push_back({"graph", file});
  for (const Body& body : plan.graph.scene.bodies) {
    if (const auto* mesh = std::get_if<MeshShape>(&body.shape)) inputs.push_back({"scene." + body.name, mesh->file});
  }
  for (const NodeSpec& node : plan.nodes) {
    // `FILE.py:Class`
    if (const std::size_t colon = node.info->python.rfind(':'); colon != std::string::npos) {
      inputs.push_back({node.name, node.info->python.substr(0, colon)});
    }
    if (!node.cost.trace_file.empty()) inputs.push_back({node.name + ".cost", node.cost.trace_file});
    for (std::size_t i = 0; i < node.params.size(); ++i) {
      for (const fs::path& file : files_of(node.info->params[i], node.params[i])) {
        inputs.push_back({node.name + "." + node.info->params[i].name, file});
      }
    }
  }
  return inputs;
}

std::set<fs::path> loaded_code() {
  std::set<fs::path> files;
  const auto add = [](dl_phdr_info* info, std::size_t, void* data) {
    // The program has no name there, and what the kernel adds has no file.
    std::error_code error;
    const fs::path file = fs::canonical(*info->dlpi_name == '\0' ? "/proc/self/exe" : info->dlpi_name, error);
    // That with the commit computes nothing, and its commit is told.
    if (!error && file.filename() != build_library_file) static_cast<std::set<fs::path>*>(data)->insert(file);
    return 0;
  };
  dl_iterate_phdr(add, &files);
  return files;
}

Provenance provenance_of(const std::vector<InputOfPlan>& inputs, const std::set<fs::path>& code,
                         const fs::path& cache_folder) {
  const BuildLibrary& build = build_library();
  Provenance made{
      this_second(), this_machine(), TACTOR_VERSION, build.commit, build.is_dirty, build.compiler, build.flags, {}, {}};
  for (const InputOfPlan& input : inputs) made.files.push_back({input.of, input.file, sha256_of_file(input.file)});
  const std::vector<fs::path> libraries(code.begin(), code.end());
  const std::vector<std::string> hashes = sha256_of_libraries(libraries, cache_folder);
  for (std::size_t i = 0; i < libraries.size(); ++i) made.libraries.push_back({"", libraries[i], hashes[i]});
  return made;
}

Provenance provenance_of(const Plan& plan, const fs::path& cache_folder) {
  return provenance_of(input_files(plan), loaded_code(), cache_folder);
}

ProvenanceJson to_json(const Provenance& made) {
  ProvenanceJson json;
  json["date"] = made.date;
  json["host"] = shown_text(made.host.node);
  json["processor"] = shown_text(made.host.processor);
  json["c_library"] = made.host.c_library;
  json["version"] = made.version;
  json["commit"] = made.commit;
  json["dirty"] = made.dirty;
  json["compiler"] = made.compiler;
  json["flags"] = made.flags;
  json["files"] = files_json(made.files);
  json["libraries"] = files_json(made.libraries);
  return json;
}

std::string provenance_text(const Provenance& made) {
  return made.empty() ? std::string() : to_json(made).dump();
}

Provenance provenance_from_json(const ProvenanceJson& json, const std::string& where) {
  try {
    const auto text = [&json](const char* key) { return json.at(key).get<std::string>(); };
    return {text("date"),
            {text("host"), text("processor"), text("c_library")},
            text("version"),
            text("commit"),
            json.at("dirty").get<bool>(),
            text("compiler"),
            text("flags"),
            files_from_json(json.at("files")),
            files_from_json(json.at("libraries"))};
  } catch (const ProvenanceJson::exception& error) {
    throw InputError(
        fmt::format("{}: expected the provenance of a result, found another form: {}", where, error.what()));
  }
}

}  // namespace tactor
