// The registry of node types: libraries are loaded by the prefix of a type name, when a graph names it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

/// Holds the declarations of the node types whose libraries are loaded. A type `prediction.ar` lives in the library
/// `libtactor_prediction.so`, looked for in the folders of TACTOR_NODE_PATH (separated by colons) and then in the given
/// ones. Libraries stay loaded until the process ends, because nodes hold code of theirs.
class Registry {
 public:
  explicit Registry(std::vector<std::filesystem::path> folders);

  /// Adds a node type, and the message types of its ports; a second node type of the same name aborts. Throws
  /// InputError if a parameter has the name of a key that every node has, if a metric is declared twice, if the lane is
  /// `realtime` and the type is not made for it, or if another node type has ports of another message type of the same
  /// name.
  void add(NodeInfo info);
  /// Makes a type known without a library, for tests and for programs that carry their own nodes.
  template <class N>
  void add() {
    add(N::declare());
  }

  /// The declaration of `type`, loading its library where needed; null where there is none.
  /// Throws InputError where the library is there and cannot be used.
  const NodeInfo* find(std::string_view type);

  /// The declaration of the class `name` in a Python file, which the library libtactor_python.so runs: it is loaded
  /// by the first call. It lives as long as the process, and is the same one until the file changes. Throws InputError,
  /// with the line of the file, where there is no such class or Python refuses the file.
  const NodeInfo& find_python(const std::filesystem::path& file, const std::string& name);

  /// Loads every library; for listings and for the nearest names in error texts. A library that cannot be used is left
  /// out, and `refused` has the reason.
  void load_all();
  /// The libraries that load_all has left out so far, with the reason of each.
  [[nodiscard]] const std::vector<std::string>& refused() const { return refused_; }

  /// The types known so far, by name.
  [[nodiscard]] std::vector<const NodeInfo*> types() const;
  /// The message types of all ports known so far, by name.
  [[nodiscard]] const std::map<std::string, const MessageType*, std::less<>>& message_types() const {
    return message_types_;
  }
  /// Why the types of `prefix` are not known: where its library was searched, and whether this build leaves it out.
  [[nodiscard]] std::string why_missing(std::string_view prefix) const;
  /// The prefixes whose libraries are loaded.
  [[nodiscard]] std::vector<std::string> loaded_libraries() const;
  /// The folders that are searched, in order.
  [[nodiscard]] const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  void add_message_type(const MessageType& type, const std::string& node);
  void load(const std::string& prefix, const std::filesystem::path& file);

  std::vector<std::filesystem::path> folders_;
  std::map<std::string, NodeInfo, std::less<>> types_;
  std::map<std::string, const MessageType*, std::less<>> message_types_;
  std::map<std::string, bool, std::less<>> libraries_;  // prefix -> found
  std::vector<std::string> refused_;
};

/// The folders of node libraries: those of this installation, then those that others added to it or to /usr/local
/// (share/tactor/nodes), then the user's (~/.local/share/tactor/nodes).
std::vector<std::filesystem::path> default_node_folders();

}  // namespace tactor
