// A node whose steps are those of a Python object.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <vector>

#include "framework/node/node.hpp"
#include "python/nodes/node_class.hpp"

namespace tactor::python {

/// Calls the object's start and step with the interpreter's lock. An exception of theirs becomes a RunError with the
/// traceback, and so does a call that would end the process (see NodeCode). A child that they fork ends with them.
class PythonNode final : public Node {
 public:
  /// Makes the object. Throws RunError with the traceback where its __init__ fails.
  PythonNode(const NodeClass& node_class, const std::vector<ParamValue>& values, const NodeContext& context);
  ~PythonNode() override;

  void start(StepContext& context) override;
  void step(StepContext& context) override;
  /// Between two steps: sets the parameters and calls the object's tune.
  void tune(const std::vector<ParamValue>& values);

  [[nodiscard]] InputBase& input(std::size_t i);
  [[nodiscard]] OutputBase& output(std::size_t i);

 private:
  struct InputPort;
  struct OutputPort;
  void make(const NodeContext& context, const std::vector<ParamValue>& values);
  void open_ports(bool open);
  void call(const pybind11::object& method, StepContext& context);

  const NodeClass& class_;
  // The object's ports share them, and may outlive the node.
  std::vector<std::shared_ptr<InputPort>> inputs_;
  std::vector<std::shared_ptr<OutputPort>> outputs_;
  pybind11::object object_, step_, start_method_, step_method_;
};

}  // namespace tactor::python
