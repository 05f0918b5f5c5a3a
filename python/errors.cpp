#include "python/errors.hpp"

#include <exception>
#include <string>

#include "framework/core/shown_text.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "python/file_text.hpp"

namespace tactor::python {

namespace py = pybind11;

namespace {

void raise(const char* name, const std::string& text, const py::list& places) {
  const py::object type = py::module_::import("tactor._errors").attr(name);
  // Python prints it to a terminal as it is.
  PyErr_SetObject(type.ptr(), type(python_text(shown_text(text)), places).ptr());
}

}  // namespace

void translate_errors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const YamlError& error) {
      py::list places;
      for (const Diagnostic& one : error.diagnostics()) {
        places.append(
            py::make_tuple(python_text(one.place.file), one.place.line, one.place.column, python_text(one.message)));
      }
      raise("InputError", error.what(), places);
    } catch (const InputError& error) {
      raise("InputError", error.what(), py::list());
    } catch (const RunError& error) {
      raise("RunError", error.what(), py::list());
    }
  });
}

}  // namespace tactor::python
