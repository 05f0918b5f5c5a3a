#include "python/nodes/node_class.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <map>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/core/messages.hpp"
#include "framework/node/registry.hpp"
#include "python/file_text.hpp"
#include "python/interpreter_lock.hpp"
#include "python/nodes/interpreter.hpp"
#include "python/nodes/node_code.hpp"
#include "python/nodes/python_node.hpp"

namespace tactor::python {

namespace fs = std::filesystem;
namespace py = pybind11;

namespace {

/// Those that all stages share are known whatever libraries are loaded.
void make_core_types_known() {
  for (const MessageType* type :
       {&message_type<Wrench>(), &message_type<Target>(), &message_type<DeviceState>(),
        &message_type<CouplingParameters>(), &message_type<PhysicsState>(), &message_type<BodyStates>(),
        &message_type<ContactSet>(), &message_type<Forecast>(), &message_type<GripperState>(),
        &message_type<GripperForce>(), &message_type<HardwareStatus>(), &message_type<ForceSegment>(),
        &message_type<SafetyState>()}) {
    make_known(*type);
  }
}

/// Throws InputError where no library has such a type.
const MessageType& message_type_of(const std::string& name, const std::string& port, Registry& registry) {
  make_core_types_known();
  if (const MessageType* type = known_message_type(name)) return *type;
  // A type of a library's own has its name in front.
  if (name.find('.') != std::string::npos) static_cast<void>(registry.find(name));
  std::string broken;
  try {
    if (known_message_type(name) == nullptr) registry.load_all();
  } catch (const InputError& error) {
    broken = std::string("; ") + error.what();
  }
  if (const MessageType* type = known_message_type(name)) return *type;
  throw InputError(port + ": expected a message type, found " + name +
                   "; `tactor schema --messages` describes them all" + broken);
}

ParamKind kind_of(const std::string& word) {
  if (word == "boolean") return ParamKind::boolean;
  if (word == "integer") return ParamKind::integer;
  if (word == "text") return ParamKind::text;
  if (word == "choice") return ParamKind::choice;
  if (word == "file") return ParamKind::file;
  if (word == "reals") return ParamKind::reals;
  TACTOR_DEMAND(word == "real");
  return ParamKind::real;
}

ParamValue value_from(const py::object& object, ParamKind kind) {
  switch (kind) {
    case ParamKind::boolean:
      return object.cast<bool>();
    case ParamKind::integer:
      return object.cast<std::int64_t>();
    case ParamKind::real:
      return object.cast<double>();
    case ParamKind::reals:
      return object.cast<std::vector<double>>();
    default:
      return object.cast<std::string>();
  }
}

ParamInfo param_from(const std::string& name, const py::object& declared) {
  ParamInfo param;
  param.name = name;
  param.kind = kind_of(declared.attr("kind").cast<std::string>());
  param.unit = declared.attr("unit").cast<std::string>();
  param.min = declared.attr("min").cast<double>();
  param.max = declared.attr("max").cast<double>();
  param.choices = declared.attr("choices").cast<std::vector<std::string>>();
  param.tunable = declared.attr("tunable").cast<bool>();
  if (declared.attr("ramp").cast<bool>()) param.meaning = ParamMeaning::ramp;
  param.doc = declared.attr("doc").cast<std::string>();
  const py::object value = declared.attr("default");
  if (!value.is_none()) param.default_value = value_from(value, param.kind);
  const py::object in_reference = declared.attr("in_reference");
  if (!in_reference.is_none()) param.in_reference = value_from(in_reference, param.kind);
  return param;
}

void add_inputs(NodeClass& made, const py::object& declared, const std::string& where, Registry& registry) {
  for (const py::handle& one : declared) {
    const auto [name, message, trigger, required, queue, doc] =
        one.cast<std::tuple<std::string, std::string, bool, bool, std::uint32_t, std::string>>();
    const MessageType& type = message_type_of(message, where + "." + name, registry);
    InputInfo input;
    input.name = name;
    input.type = &type;
    input.doc = doc;
    input.trigger = trigger ? Trigger::yes : Trigger::no;
    input.required = required;
    if (queue > 1) input.queue = {QueuePolicy::drop_oldest, queue};
    input.access = [i = made.info.inputs.size()](Node& node) -> InputBase& {
      return dynamic_cast<PythonNode&>(node).input(i);
    };
    made.info.inputs.push_back(std::move(input));
    made.inputs.emplace_back(type);
  }
}

void add_outputs(NodeClass& made, const py::object& declared, const std::string& where, Registry& registry) {
  for (const py::handle& one : declared) {
    const auto [name, message, doc] = one.cast<std::tuple<std::string, std::string, std::string>>();
    const MessageType& type = message_type_of(message, where + "." + name, registry);
    OutputInfo output{name, &type, doc, [i = made.info.outputs.size()](Node& node) -> OutputBase& {
                        return dynamic_cast<PythonNode&>(node).output(i);
                      }};
    made.info.outputs.push_back(std::move(output));
    made.outputs.emplace_back(type);
  }
}

void add_params(NodeInfo& info, const py::object& declared) {
  bool tunable = false;
  for (const py::handle& one : declared) {
    const auto [name, param] = one.cast<std::pair<std::string, py::object>>();
    if (param.attr("rate").cast<bool>()) info.rate_parameter = info.params.size();
    info.params.push_back(param_from(name, param));
    if (param.attr("fixed").cast<bool>()) info.params.back().in_reference = 0.0;  // see make_reference_plan
    tunable = tunable || info.params.back().tunable;
  }
  if (!tunable) return;
  info.tuning = {.typed = [](const ParamValues& values) -> std::shared_ptr<const void> {
                   return std::make_shared<const ParamValues>(values);
                 },
                 .tune =
                     [](Node& node, const void* values) {
                       dynamic_cast<PythonNode&>(node).tune(*static_cast<const ParamValues*>(values));
                     },
                 .refuses = {}};
}

/// Throws py::error_already_set too, where Python code of the file does.
NodeClass& make_class(const fs::path& file, const py::object& cls, const std::string& code, Registry& registry) {
  const py::dict declared = node_module().attr("describe")(cls);
  // Kept on purpose, also where this throws half-way: objects of Python must not be destroyed without its lock.
  auto& made = *new NodeClass;
  made.cls = cls;
  NodeInfo& info = made.info;
  const auto name = declared["name"].cast<std::string>();
  info.type = "python." + name;
  info.python = file.string() + ":" + name;
  info.code = content_key({code});
  info.summary = declared["summary"].cast<std::string>();
  info.details = declared["details"].cast<std::string>();
  info.role = role_of(declared["role"].cast<std::string>());
  const std::string where = info.python;
  add_inputs(made, declared["inputs"], where, registry);
  add_outputs(made, declared["outputs"], where, registry);
  add_params(info, declared["parameters"]);
  if (info.outputs.empty()) {
    info.sink = true;
    info.role = Role::sink;
  }
  info.nature =
      Making{.create = [&made](const ParamValues& values, const NodeContext& context) -> std::unique_ptr<Node> {
               return std::make_unique<PythonNode>(made, values, context);
             },
             .check = [&made](const ParamValues& values,
                              const NodeContext& context) { static_cast<void>(PythonNode(made, values, context)); }};
  return made;
}

}  // namespace

const NodeInfo& declare(const fs::path& file, const std::string& name, Registry& registry) {
  start_interpreter();
  const LockHeld lock;
  const py::module_ module = node_module();
  const NodeCode code_of_node;
  try {
    const auto [cls, code] =
        module.attr("load")(python_text(file.native()), name).cast<std::pair<py::object, std::string>>();
    // Guarded by the interpreter's lock; a class lives as long as its entry here.
    static std::map<PyObject*, NodeClass*> known;
    NodeClass*& entry = known[cls.ptr()];
    if (entry == nullptr) entry = &make_class(file, cls, code, registry);
    return entry->info;
  } catch (py::error_already_set& error) {
    code_of_node.end_child(&error);
    static_cast<void>(NodeCode::kept_alive());  // the error tells it
    if (error.matches(module.attr("Refused"))) throw InputError(bytes_of_text(py::str(error.value())));
    throw InputError(file.string() + ": " + traceback_of(error));
  }
}

}  // namespace tactor::python
