"""What scripts/own_physics_results makes of metrics made up by hand, and the physics of bench/own_loop.py against closed forms."""
import importlib.machinery
import importlib.util
import pathlib
import unittest

try:
    import numpy as np
except ModuleNotFoundError:  # the loop in Python needs it, and so does the script
    raise SystemExit(77)

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/own_physics_results"
spec = importlib.util.spec_from_loader("own_physics_results", importlib.machinery.SourceFileLoader("own_physics_results", str(SCRIPT)))
script = importlib.util.module_from_spec(spec)
spec.loader.exec_module(script)
own_physics, own_loop = script.own_physics, script.own_loop


def row(rms, worst, us=1.0):
    """A row of a study, by the errors of its seeds."""
    def of(values):
        return {"by_seed": values}

    return {"metrics": {own_physics.RMS: of(rms), own_physics.WORST: of(worst), own_physics.DELAY: of([None] * len(rms)),
                        "method_us_per_tick": of([us]), "cost_us.physics.median": of([us]), "cpu_ms_per_s": of([us])}}


def found():
    """Two scenes with two seeds; `local` cannot be laid over the second."""
    a = {"hold": row([2.0, 4.0], [8.0, 8.0]), "local": row([1.0, 3.0], [8.0, 4.0], 3.0), "floor": row([1.0, 1.0], [1.0, 1.0])}
    b = {"hold": row([1.0, 1.0], [2.0, 2.0]), "floor": row([0.25, 0.75], [1.0, 1.0])}
    return {(scene, rate): methods for rate in own_physics.RATES for scene, methods in (("a", a), ("b", b))}


def cells(table):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.strip().splitlines()]


class Virtual(unittest.TestCase):
    def test_a_ratio_is_of_runs_with_the_same_seed_and_the_worst_scene_is_named(self):
        rows = {one[0]: one for one in own_physics.summary(found(), 60)}
        self.assertEqual(rows["`local`"][1:6], [1, 0.625, "0.625 (a)", 0.75, 0.75])
        self.assertEqual(rows["`floor`"][1:6], [2, (0.375 + 0.5) / 2, "0.5 (b)", 0.75, 0.75])
        self.assertEqual(rows["`local`"][6:], [0.75, "0.75 (a)", None, None, 3.0, 3.0])
        against = {one[0]: one for one in own_physics.costs(found(), 60)}
        self.assertEqual(against["`local`"][1:3], [2.0, "2 (a)"])

    def test_a_scene_shows_the_hold_in_newtons_and_a_method_that_is_refused_as_missing(self):
        self.assertEqual(list(own_physics.by_scene(found(), 60, own_physics.RMS)),
                         [["`hold`, N", 3.0, 1.0], ["`local`", "0.625; 0.75", None], ["`floor`", "0.375; 0.5", "0.5; 0.75"]])

    def test_scenes_with_the_same_methods_make_one_study(self):
        groups = own_physics.groups({"a": None, "b": None, "c": None}, {("b", "local"): "why"})
        self.assertEqual(sorted(groups.values()), [["a", "c"], ["b"]])
        self.assertTrue(all(("local" in methods) == ("a" in of) for methods, of in groups.items()))

    def test_the_scenes_are_graphs_with_a_model_of_their_name(self):
        names = own_physics.scenes()
        self.assertGreaterEqual(len(names), 5)
        for scene, file in names.items():
            self.assertTrue(file.with_name(f"{scene}.xml").exists(), scene)


class Live(unittest.TestCase):
    def test_misses_stand_beside_those_of_the_control_and_p99_is_that_of_the_worst_run(self):
        def run(missed, p99):
            return {"duration_s": 6, "device": {"ticks": 100, "missed": missed, "body_us": {"p99": p99}}, "physics": {"rate_hz_median": 100},
                    "cost_us": {"resimulation": {"median": 10, "p99": p99}}, "delivered": {"force": {"rms_error_N": 0.5}}}

        hold = run(2, 5)
        hold["cost_us"] = {}
        head = own_physics.LIVE_HEAD
        control, method = (dict(zip(head, one)) for one in own_physics.live_rows({"a": {"hold": [hold], "rollout": [run(1, 400), run(0, 5000)]}}))
        self.assertEqual((method["missed"], method["control missed"], method["s"]), (1, 2, 12))
        self.assertEqual((method["p99, worst run"], method["p99 / period of physics"]), (5000, 0.5))
        self.assertIsNone(method["allocations in the loop"])
        self.assertIsNone(control["re-simulation, p50, us"])


class Coupling(unittest.TestCase):
    def test_a_run_that_was_reset_or_is_off_by_more_than_the_force_is_unstable(self):
        self.assertEqual(own_physics.behaviour({"resets": 0, "rms_error_N": 0.5}, 1), "stable")
        self.assertIn("unstable", own_physics.behaviour({"resets": 1, "rms_error_N": None}, 1))
        self.assertIn("unstable", own_physics.behaviour({"resets": 0, "rms_error_N": 1.5}, 1))


class Loop(unittest.TestCase):
    def test_the_curvature_that_is_told_is_the_hessian_of_the_distance(self):
        centre, radius, e = np.array([0.01, 0, -0.02]), 0.024, 1e-5
        p = np.array([0.012, 0.003, 0.006])

        def distance(at):
            return own_loop.sphere(at, centre, radius)[0]

        told = own_loop.contacts(p, lambda at: [own_loop.sphere(at, centre, radius)])[0]
        steps = e * np.eye(3)
        by_differences = [[(distance(p + a + b) - distance(p + a - b) - distance(p - a + b) + distance(p - a - b)) / (4 * e * e) for b in steps]
                          for a in steps]
        np.testing.assert_allclose(told["H_W"], np.array(by_differences)[np.triu_indices(3)], atol=1e-3)
        self.assertAlmostEqual(told["distance"], distance(p) - own_loop.RADIUS)

    def test_a_ball_that_rests_and_slides_on_a_plane_feels_spring_and_friction(self):
        p, depth = np.array([0, 0, own_loop.RADIUS - 1e-3]), 1e-3
        normal = own_loop.STIFFNESS * depth
        np.testing.assert_allclose(own_loop.law(p, np.zeros(3), own_loop.SCENES["plane"]), [0, 0, normal])
        np.testing.assert_allclose(own_loop.law(p, np.array([0.1, 0, 0]), own_loop.SCENES["plane"]), [-own_loop.FRICTION * normal, 0, normal])

    def test_the_error_is_that_of_the_part_that_is_judged(self):
        times = np.array([own_loop.WARM - 1, own_loop.WARM + 0.5, own_loop.WARM + 1])
        truth = (np.array([0.0, own_loop.WARM + 2]), np.zeros((2, 3)))
        self.assertEqual(own_loop.error((times, np.array([[9.0, 0, 0], [3.0, 0, 0], [0, 4.0, 0]])), truth), ((25 / 2) ** 0.5, 4.0))


class Page(unittest.TestCase):
    def test_every_key_of_the_page_has_a_value(self):
        loop = {"plane": [{(rate, method): (0.5, 1.0, 7.0) for rate in own_loop.RATES for method in own_loop.METHODS}]}
        one = {"rms_error_N": 0.1, "max_error_N": 0.2, "resets": 0, "step_p50_us": 1, "step_p99_us": 2}
        coupling = [{"scene": "ball", "degrees": 3, "mass_kg": 0.05, "truth_rms_N": 1.0, "rows_at_truth_step": one,
                     "steps": [{"step_s": 1e-3, "bound": 1.0, "rows": one, "held": one}]}]
        bridge = [{"row": "echo", "count": 1, "p50_us": 1, "p99_us": 2, "max_us": 3}]
        values = script.values(found(), {("b", "local"): "it has no box"}, loop, coupling, bridge, {})
        others = dict.fromkeys(("MACHINE", "MINUTES", "SEEDS", "LIVE_SECONDS", "BRIDGE_SECONDS", "BRIDGE_RATE"), "here")
        text = script.page.filled(SCRIPT.with_name("own_physics_results.template.md").read_text(), values | others)
        self.assertIn("- `local` over `b`: it has no box", text)
        self.assertIn("the RMS error is 0.62 / 0.62 / 0.62 of that", text)


if __name__ == "__main__":
    unittest.main()
