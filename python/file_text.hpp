// Texts that may hold paths, between C++ and Python: a path is bytes here, and a str with escapes there (os.fsdecode).
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <string_view>
#include <vector>

namespace tactor::python {

/// With the interpreter's lock.
inline pybind11::str python_text(std::string_view text) {
  PyObject* made = PyUnicode_DecodeFSDefaultAndSize(text.data(), static_cast<Py_ssize_t>(text.size()));
  if (made == nullptr) throw pybind11::error_already_set();
  return pybind11::reinterpret_steal<pybind11::str>(made);
}

inline pybind11::list python_texts(const std::vector<std::string>& texts) {
  pybind11::list made;
  for (const std::string& text : texts) made.append(python_text(text));
  return made;
}

/// Of a str. With the interpreter's lock.
inline std::string bytes_of_text(const pybind11::handle& text) {
  const auto bytes = pybind11::reinterpret_steal<pybind11::bytes>(PyUnicode_EncodeFSDefault(text.ptr()));
  if (!bytes) throw pybind11::error_already_set();
  return bytes;
}

}  // namespace tactor::python
