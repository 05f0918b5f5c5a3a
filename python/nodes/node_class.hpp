// A class of a Python file as a node type: its declaration, and what all of its nodes share.
#pragma once

#include <pybind11/pybind11.h>

#include <deque>
#include <filesystem>
#include <string>

#include "framework/node/info.hpp"
#include "python/message_arrays.hpp"

namespace tactor {
class Registry;
}

namespace tactor::python {

/// A declared class. It is never destroyed, because nodes and plans may outlive whatever asked for it.
struct NodeClass {
  NodeInfo info;
  pybind11::object cls;
  std::deque<MessageArrays> inputs, outputs;  ///< in the order of those of `info`
};

/// The class `name` of a Python file; the same object as long as the file's code is the same. Throws InputError with
/// the file and the line, where the file, the class or its declaration cannot be used.
const NodeInfo& declare(const std::filesystem::path& file, const std::string& name, Registry& registry);

}  // namespace tactor::python
