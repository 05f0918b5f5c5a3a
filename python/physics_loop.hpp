// A program in Python whose own simulator is the physics of a session.
#pragma once

#include <pybind11/pybind11.h>

namespace tactor::python {

/// Adds the classes PhysicsLoop and PhysicsStep. Poses with velocities go as rows of 13 numbers: p, R (w, x, y, z), v,
/// w.
void bind_physics_loop(pybind11::module_& module);

}  // namespace tactor::python
