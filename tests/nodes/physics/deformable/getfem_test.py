"""Elastic boxes sag as GetFEM says: linear elasticity, and the stable neo-Hookean law under a large load.

getfem_test.py ANSWERS: the program that writes boxes with our displacements. GetFEM gets the mesh, the moduli and gravity alone, and
derives forces and stiffness of the neo-Hookean law from its energy by itself.
"""
import json
import os
import subprocess
import sys
import unittest

import numpy as np

try:
    import getfem as gf
except ImportError:
    print("skipped: getfem is not installed (python3-getfem)")
    sys.exit(77)

gf.util_trace_level(0)
ANSWERS = sys.argv.pop(1)
FACE = 1


def displaced(box, degree, large):
    """GetFEM's displacement of each node, in the order of the box's nodes."""
    nodes = np.array(box["nodes"])
    mesh = gf.Mesh("empty", 3)
    for tet in box["tets"]:
        mesh.add_convex(gf.GeoTrans("GT_PK(3,1)"), nodes[tet].T)
    faces = mesh.outer_faces()
    points = mesh.pts()
    held = [k for k in range(faces.shape[1])
            if np.all(points[0, mesh.pid_in_faces(faces[:, k])] < 1e-9)]
    mesh.set_region(FACE, faces[:, held])
    field = gf.MeshFem(mesh, 3)
    field.set_fem(gf.Fem(f"FEM_PK(3,{degree})"))
    # Four points, exact to the second degree; gravity by more.
    points_of_energy = gf.MeshIm(mesh, gf.Integ(f"IM_TETRAHEDRON({2 if degree == 2 else 1})"))
    many_points = gf.MeshIm(mesh, gf.Integ("IM_TETRAHEDRON(5)"))
    model = gf.Model("real")
    model.add_fem_variable("u", field)
    mu = box["young"] / (2 * (1 + box["poisson"]))
    la = box["young"] * box["poisson"] / ((1 + box["poisson"]) * (1 - 2 * box["poisson"]))
    if large:
        model.add_initialized_data("mu", [4 / 3 * mu])
        model.add_initialized_data("la", [la + 5 / 6 * mu])
        square = "Norm_sqr(Id(3)+Grad_u)"
        model.add_nonlinear_term(points_of_energy, f"mu/2*({square}-3) + la/2*sqr(Det(Id(3)+Grad_u) - 1 - 3*mu/(4*la)) "
                                                   f"- mu/2*log({square}+1)")
    else:
        model.add_initialized_data("mu", [mu])
        model.add_initialized_data("la", [la])
        model.add_isotropic_linearized_elasticity_brick(points_of_energy, "u", "la", "mu")
    model.add_initialized_data("weight", [0.0, 0.0, 0.0])
    model.add_source_term_brick(many_points, "u", "weight")
    model.add_Dirichlet_condition_with_simplification("u", FACE)
    steps = 40 if large else 1
    for step in range(1, steps + 1):
        model.set_variable("weight", step / steps * box["density"] * np.array(box["gravity"]))
        _, converged = model.solve("max_res", 1e-12, "max_iter", 100, "lsolver", "mumps")
        if not converged:
            raise RuntimeError(f"GetFEM finds no balance in step {step} of {steps}")
    values = model.variable("u").reshape(-1, 3)
    places = field.basic_dof_nodes()[:, ::3].T
    at = {tuple(np.round(1e6 * p).astype(int)): v for p, v in zip(places, values, strict=True)}
    return np.array([at[tuple(np.round(1e6 * p).astype(int))] for p in nodes])


class GetFem(unittest.TestCase):
    def compare(self, order, load):
        said = subprocess.run([ANSWERS, order, load], check=True, capture_output=True, text=True).stdout
        box = json.loads(said)
        ours = np.array(box["moved_by"])
        theirs = displaced(box, 1 if order == "linear" else 2, load == "large")
        largest = np.abs(theirs).max()
        print(f"{order}, {load} load: largest displacement {1e3 * largest:.3g} mm, largest difference {np.abs(ours - theirs).max() / largest:.2g} of it")
        self.assertLess(np.abs(ours - theirs).max(), 1e-6 * largest)
        return largest

    def test_linear_elements_under_a_small_load(self):
        self.compare("linear", "small")

    def test_quadratic_elements_under_a_small_load(self):
        self.compare("quadratic", "small")

    def test_linear_elements_under_a_large_load(self):
        # So that the load is large: a fifth of the length.
        self.assertGreater(self.compare("linear", "large"), 0.01)

    def test_quadratic_elements_under_a_large_load(self):
        self.assertGreater(self.compare("quadratic", "large"), 0.01)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    unittest.main(verbosity=2)
