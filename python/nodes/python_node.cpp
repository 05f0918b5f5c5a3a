#include "python/nodes/python_node.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cstring>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/processor_dependence.hpp"
#include "framework/node/port.hpp"
#include "python/file_text.hpp"
#include "python/interpreter_lock.hpp"
#include "python/nodes/interpreter.hpp"
#include "python/nodes/node_code.hpp"

namespace tactor::python {

namespace py = pybind11;

namespace {

/// A copy of the message, as one numpy record.
py::object record_of(const MessageArrays& arrays, const MessageView& message) {
  std::vector<std::byte> bytes(arrays.message_size());
  std::memcpy(bytes.data(), message.stamp, sizeof(Stamp));
  std::memcpy(bytes.data() + arrays.value_offset(), message.value, arrays.type().size);
  retain(arrays.type(), message.value);
  return py::object(arrays.take(std::move(bytes))[py::int_(0)]);
}

Time time_of(const py::object& valid_ns) {
  PyObject* index = PyNumber_Index(valid_ns.ptr());
  if (index == nullptr) {
    PyErr_Clear();
    throw py::type_error("valid_ns: expected a time of the run in ns, an integer, found " +
                         py::repr(valid_ns).cast<std::string>());
  }
  return Time{py::reinterpret_steal<py::int_>(index).cast<std::int64_t>()};
}

/// Time must not run backwards by a cost, so a step works on nothing or more.
std::int64_t work_of(const py::object& work) {
  constexpr std::int64_t most = 1'000'000'000;
  if (py::isinstance<py::int_>(work)) {
    const std::int64_t items = PyLong_AsLongLong(work.ptr());
    if (items >= 0 && items <= most) return items;
    PyErr_Clear();
  }
  throw RunError("step.work: expected an integer from 0 to 1000000000, found " + py::repr(work).cast<std::string>());
}

py::dict dict_of(const NodeInfo& info, const std::vector<ParamValue>& values) {
  py::dict made;
  for (std::size_t i = 0; i < values.size(); ++i) {
    made[info.params[i].name.c_str()] = std::visit(
        [](const auto& value) -> py::object {
          using T = std::decay_t<decltype(value)>;
          if constexpr (std::is_same_v<T, Table> || std::is_same_v<T, Mapping> || std::is_same_v<T, std::monostate>) {
            TACTOR_DEMAND(!"a class declares no such parameter");
            return py::none();
          } else if constexpr (std::is_same_v<T, std::string>) {
            return python_text(value);
          } else {
            return py::cast(value);
          }
        },
        values[i]);
  }
  return made;
}

const char* word_of(Phase phase) {
  switch (phase) {
    case Phase::starting:
      return "starting";
    case Phase::running:
      break;
    case Phase::stopping:
      return "stopping";
  }
  return "running";
}

/// The RunError for what a method has raised.
RunError failed(const py::error_already_set& error) {
  if (!error.matches(PyExc_KeyboardInterrupt) || is_own_interpreter()) return RunError(traceback_of(error));
  // It was not meant for the node: Python raises it once more where the run has ended.
  PyErr_SetInterrupt();
  return RunError("interrupted");
}

/// Does what calls the code of a node. Throws RunError where the code raises, or asks for the end of the process.
template <class Work>
void run_code(const Work& work) {
  const NodeCode code;
  try {
    work();
  } catch (py::error_already_set& error) {
    code.end_child(&error);
    static_cast<void>(NodeCode::kept_alive());  // the error tells it
    throw failed(error);
  }
  code.end_child(nullptr);
  if (const auto asked = NodeCode::kept_alive()) throw RunError(*asked);
}

[[noreturn]] void refuse_closed() {
  throw std::runtime_error("a port works while its node is in start or step, and at no other time");
}

}  // namespace

struct PythonNode::InputPort {
  InputPort(const MessageArrays& of) : arrays(of), port(of.type()) {}

  py::object latest() {
    if (!open) refuse_closed();
    const MessageView message = port.latest();
    return message ? record_of(arrays, message) : py::none();
  }
  /// As NewMessages: an engine has marked a `latest` message as seen, so that it can't be taken.
  py::list take_new() {
    if (!open) refuse_closed();
    py::list found;
    while (const MessageView message = port.take()) found.append(remembered(message));
    const MessageView newest = port.latest();
    const bool seen = newest && any && newest.stamp->valid == last.valid && newest.stamp->sequence == last.sequence;
    if (newest && !seen) found.append(remembered(newest));
    return found;
  }
  py::object remembered(const MessageView& message) {
    last = *message.stamp;
    any = true;
    return record_of(arrays, message);
  }

  const MessageArrays& arrays;
  AnyInput port;
  Stamp last;
  bool any = false;
  bool open = false;  ///< while the node starts or steps; afterwards the engine has it, without the interpreter's lock
};

struct PythonNode::OutputPort {
  OutputPort(const MessageArrays& of, std::string where_from) : arrays(of), where(std::move(where_from)) {
    port.set_type(of.type());
  }

  void send(const py::object& valid_ns, py::object value) {
    if (!open) refuse_closed();
    const Time valid = time_of(valid_ns);
    const py::module_ numpy = py::module_::import("numpy");
    if (py::isinstance(value, numpy.attr("void"))) value = numpy.attr("asarray")(value);
    try {
      const OwnedValue owned = arrays.value_of(value, where);
      port.send(valid, owned.data());
    } catch (const InputError& error) {
      throw py::value_error(error.what());
    }
  }
  py::object zeros() const {
    return py::module_::import("numpy").attr("zeros")(py::tuple(), arrays.value_dtype())[py::tuple()];
  }

  const MessageArrays& arrays;
  std::string where;
  AnyOutput port;
  bool open = false;  ///< while the node starts or steps; afterwards the engine has it, without the interpreter's lock
};

PythonNode::PythonNode(const NodeClass& node_class, const std::vector<ParamValue>& values, const NodeContext& context)
    : class_(node_class) {
  const NodeInfo& info = class_.info;
  // What numpy and the C library compute for it is their own affair.
  note_processor_dependence("the node type " + info.type + ", which is in Python");
  for (const MessageArrays& arrays : class_.inputs) inputs_.push_back(std::make_shared<InputPort>(arrays));
  for (std::size_t i = 0; i < class_.outputs.size(); ++i) {
    outputs_.push_back(std::make_shared<OutputPort>(class_.outputs[i], info.outputs[i].name));
  }
  const LockHeld lock;
  try {
    run_code([&] { make(context, values); });
  } catch (const RunError& error) {
    for (py::object* one : {&object_, &step_, &start_method_, &step_method_}) *one = py::object();
    throw RunError("node " + context.name + " (" + info.python + ") cannot be made: " + error.what());
  }
}

void PythonNode::make(const NodeContext& context, const std::vector<ParamValue>& values) {
  const NodeInfo& info = class_.info;
  py::list ports;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const std::shared_ptr<InputPort> port = inputs_[i];
    py::dict functions;
    functions["latest"] = py::cpp_function([port] { return port->latest(); });
    functions["new"] = py::cpp_function([port] { return port->take_new(); });
    ports.append(py::make_tuple(info.inputs[i].name, functions));
  }
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const std::shared_ptr<OutputPort> port = outputs_[i];
    py::dict functions;
    functions["send"] =
        py::cpp_function([port](const py::object& valid, const py::object& value) { port->send(valid, value); },
                         py::arg("valid_ns"), py::arg("value"));
    functions["zeros"] = py::cpp_function([port] { return port->zeros(); });
    functions["wanted"] = py::cpp_function([port] { return port->port.wanted(); });
    ports.append(py::make_tuple(info.outputs[i].name, functions));
  }
  const py::module_ module = node_module();
  object_ =
      module.attr("make")(class_.cls, ports, dict_of(info, values),
                          py::make_tuple(python_text(context.name), context.seed, context.torque, context.duration.ns));
  step_ = module.attr("Step")();
  start_method_ = object_.attr("start");
  step_method_ = object_.attr("step");
}

PythonNode::~PythonNode() {
  const LockHeld lock;
  for (py::object* one : {&step_method_, &start_method_, &step_, &object_}) *one = py::object();
}

InputBase& PythonNode::input(std::size_t i) {
  return inputs_[i]->port;
}

OutputBase& PythonNode::output(std::size_t i) {
  return outputs_[i]->port;
}

void PythonNode::open_ports(bool open) {
  for (const auto& port : inputs_) port->open = open;
  for (const auto& port : outputs_) port->open = open;
}

void PythonNode::call(const py::object& method, StepContext& context) {
  const LockHeld lock;
  const auto close = [this](void*) { open_ports(false); };
  open_ports(true);
  const std::unique_ptr<void, decltype(close)> closing(this, close);
  run_code([&] {
    step_.attr("now_ns") = context.now().ns;
    step_.attr("phase") = word_of(context.phase());
    step_.attr("work") = 0;
    // A step that the program leaves behind as it ends is ended by Python, which must not reach the engine's frames.
    const auto answer = py::reinterpret_steal<py::object>(
        parked_at_end([&] { return PyObject_CallOneArg(method.ptr(), step_.ptr()); }));
    if (!answer) throw py::error_already_set();
    context.add_work(work_of(step_.attr("work")));
  });
}

void PythonNode::start(StepContext& context) {
  call(start_method_, context);
}

void PythonNode::step(StepContext& context) {
  call(step_method_, context);
}

void PythonNode::tune(const std::vector<ParamValue>& values) {
  const LockHeld lock;
  try {
    run_code([&] {
      node_module().attr("assign")(object_, dict_of(class_.info, values));
      object_.attr("tune")();
    });
  } catch (const RunError& error) {
    throw RunError(class_.info.python + ": " + error.what());
  }
}

}  // namespace tactor::python
