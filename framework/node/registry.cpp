#include "framework/node/registry.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/node/abi.hpp"
#include "framework/node/plugin.hpp"
#include "framework/node/python_library.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view library_prefix = "libtactor_";
constexpr std::string_view library_suffix = ".so";

// Declarations come from libraries of users too, so a wrong one is bad input.
void check(const NodeInfo& info) {
  for (const ParamInfo& param : info.params) {
    if (std::find(node_keys.begin(), node_keys.end(), param.name) == node_keys.end()) continue;
    throw InputError("the node type " + info.type + " declares the parameter \"" + param.name +
                     "\", which is a key of every node; give it another name");
  }
  std::vector<std::string_view> metrics;
  for (const MetricInfo& metric : info.metrics) {
    if (std::find(metrics.begin(), metrics.end(), metric.name) != metrics.end()) {
      throw InputError("the node type " + info.type + " declares the metric " + metric.name +
                       " twice; declare it once");
    }
    metrics.push_back(metric.name);
  }
  if (info.lane == Lane::realtime && (!info.realtime_safe || !info.rate_parameter)) {
    throw InputError("the node type " + info.type +
                     " declares the lane realtime, which needs real-time safe steps and a rate, found " +
                     (info.realtime_safe ? "no rate" : "steps that are not") + "; declare what is missing");
  }
}

}  // namespace

Registry::Registry(std::vector<fs::path> folders) {
  if (const char* path = std::getenv("TACTOR_NODE_PATH")) {
    std::istringstream list(path);
    for (std::string folder; std::getline(list, folder, ':');) {
      if (!folder.empty()) folders_.emplace_back(folder);
    }
  }
  folders_.insert(folders_.end(), folders.begin(), folders.end());
}

void Registry::add(NodeInfo info) {
  check(info);
  for (const InputInfo& input : info.inputs) add_message_type(*input.type, info.type);
  for (const OutputInfo& output : info.outputs) {
    if (!output.type_of) add_message_type(*output.type, info.type);
  }
  const std::string type = info.type;
  TACTOR_DEMAND(types_.emplace(type, std::move(info)).second);
}

void Registry::add_message_type(const MessageType& type, const std::string& node) {
  make_known(type);
  const auto [known, added] = message_types_.try_emplace(type.name, &type);
  if (added || same_type(*known->second, type)) return;
  throw InputError("the node type " + node + " has ports of the message type " + type.name +
                   ", and another node type has ports of another type with that name; rename one of them");
}

const NodeInfo* Registry::find(std::string_view type) {
  if (const auto it = types_.find(type); it != types_.end()) return &it->second;
  const std::size_t dot = type.find('.');
  if (dot == std::string_view::npos || type.find('/') != std::string_view::npos) return nullptr;
  const std::string prefix(type.substr(0, dot));
  if (!libraries_.contains(prefix)) {
    libraries_[prefix] = false;
    for (const fs::path& folder : folders_) {
      const fs::path file = folder / (std::string(library_prefix) + prefix + std::string(library_suffix));
      if (fs::exists(file)) {
        load(prefix, file);
        break;
      }
    }
  }
  const auto it = types_.find(type);
  return it == types_.end() ? nullptr : &it->second;
}

const NodeInfo& Registry::find_python(const fs::path& file, const std::string& name) {
  static const auto& library =
      load_plugin<PythonLibrary>(python_library_file, python_library_entry,
                                 "a node in Python needs the package python3-tactor, or a build with pybind11");
  const NodeInfo& info = library.declare(file, name, *this);
  check(info);
  for (const InputInfo& input : info.inputs) add_message_type(*input.type, info.type);
  for (const OutputInfo& output : info.outputs) add_message_type(*output.type, info.type);
  return info;
}

void Registry::load_all() {
  for (const fs::path& folder : folders_) {
    std::error_code ignored;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      const std::string name = file.filename().string();
      if (!name.starts_with(library_prefix) || !name.ends_with(library_suffix)) continue;
      const std::string prefix =
          name.substr(library_prefix.size(), name.size() - library_prefix.size() - library_suffix.size());
      if (libraries_.contains(prefix) && libraries_.at(prefix)) continue;
      try {
        load(prefix, file);
      } catch (const InputError& error) {
        const std::string why = error.what();
        if (std::find(refused_.begin(), refused_.end(), why) == refused_.end()) refused_.push_back(why);
      }
    }
  }
}

std::vector<const NodeInfo*> Registry::types() const {
  std::vector<const NodeInfo*> result;
  for (const auto& [name, info] : types_) result.push_back(&info);
  return result;
}

std::string Registry::why_missing(std::string_view prefix) const {
  std::string searched;
  for (const fs::path& folder : folders_) searched.append(searched.empty() ? "" : ", ").append(folder.string());
  std::string text("the library ");
  text.append(library_prefix).append(prefix).append(library_suffix).append(" was not found in ");
  text.append(searched.empty() ? "any folder" : searched);
  if (const char* path = std::getenv("TACTOR_NODE_PATH"); path == nullptr || *path == '\0') {
    text.append("; a library of your own is looked for in the folders of TACTOR_NODE_PATH, which is not set");
  } else {
    text.append("; a library of your own is looked for in the folders of TACTOR_NODE_PATH, which is ").append(path);
  }
  return text;
}

std::vector<std::string> Registry::loaded_libraries() const {
  std::vector<std::string> result;
  for (const auto& [prefix, found] : libraries_) {
    if (found) result.push_back(prefix);
  }
  return result;
}

void Registry::load(const std::string& prefix, const fs::path& file) {
  check_abi(file);
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw InputError("cannot load the node library " + file.string() + ": " + dlerror());
  const auto register_nodes = reinterpret_cast<void (*)(Registry&)>(dlsym(handle, "tactor_register_nodes"));
  if (register_nodes == nullptr) {
    throw InputError(file.string() +
                     " is not a node library: it does not export tactor_register_nodes (see TACTOR_NODES)");
  }
  libraries_[prefix] = true;
  register_nodes(*this);
}

std::vector<fs::path> default_node_folders() {
  std::vector<fs::path> folders;
  const fs::path installed = fs::path("share") / "tactor" / "nodes";
  for (const fs::path& folder :
       {library_folder() / "tactor", installation_prefix() / installed, fs::path("/usr/local") / installed}) {
    if (fs::exists(folder)) folders.push_back(folder);
  }
  if (const fs::path data = user_data_folder(); !data.empty()) folders.push_back(data / "nodes");
  return folders;
}

}  // namespace tactor
