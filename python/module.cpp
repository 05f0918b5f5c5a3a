// The extension `tactor._tactor`, on which the package tactor stands.
#include <pybind11/pybind11.h>

#include "framework/core/installation.hpp"
#include "python/ending.hpp"
#include "python/errors.hpp"
#include "python/file_text.hpp"
#include "python/graph.hpp"
#include "python/physics_loop.hpp"
#include "python/run_result.hpp"
#include "python/session.hpp"

PYBIND11_MODULE(_tactor, module) {
  module.attr("version") = TACTOR_VERSION;
  module.attr("prefix") = tactor::python::python_text(tactor::installation_prefix().native());
  module.def("end_work", tactor::python::end_work);
  module.def("forget_work", tactor::python::forget_work);
  tactor::python::translate_errors();
  tactor::python::bind_graph(module);
  tactor::python::bind_session(module);
  tactor::python::bind_physics_loop(module);
  tactor::python::bind_run(module);
}
