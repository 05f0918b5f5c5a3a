"""Sessions from Python: taps, feeds, parameters, threads, misuse, memory."""
import concurrent.futures
import gc
import itertools
import os
import threading
import time
import unittest

import numpy

from package_harness import EDGES_OF_A_SMALL_GRAPH, WALL, PackageTest, needs_devices, needs_live, tactor


def resident_MB():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) / 1024


class Taps(PackageTest):
    def test_a_minute_at_1_khz_arrives_whole_as_one_array(self):
        with tactor.Session(WALL, duration="60 s") as session:
            tap = session.tap("device.commanded")
            session.run()
            force = tap.take()
        self.assertEqual(force.shape, (60_000,))
        numpy.testing.assert_array_equal(force["valid_ns"], numpy.arange(60_000) * 1_000_000)
        numpy.testing.assert_array_equal(force["sequence"], numpy.arange(60_000))
        self.assertEqual((tap.dropped, session.dropped, len(tap.take())), (0, 0, 0))
        self.assertEqual(force.units, {"valid_ns": "ns", "produced_ns": "ns", "sequence": "1", "force": "N", "torque": "N m"})
        self.assertEqual(force.attrs["output"], "device.commanded")

    def test_messages_do_not_depend_on_how_time_is_cut(self):
        def taken(cuts):
            with tactor.Session(WALL, duration="2 s") as session:
                tap = session.tap("coupling.force")
                parts = []
                for cut in cuts:
                    session.advance(cut)
                    parts.append(numpy.asarray(tap.take()))
                return numpy.concatenate(parts)
        whole = taken([2])
        self.assertGreater(len(whole), 100)
        numpy.testing.assert_array_equal(whole, taken(["0.3 ms"] * 20 + [0.1, "1 s", 5]))

    def test_a_bounded_tap_keeps_the_newest_and_counts_the_others(self):
        with tactor.Session(WALL, duration="1 s") as session:
            tap = session.tap("device.commanded", queue=7)
            session.advance("10 ms")
            numpy.testing.assert_array_equal(tap.take()["sequence"], numpy.arange(3, 10))
            self.assertEqual(tap.dropped, 3)
            session.advance("3 ms")
            numpy.testing.assert_array_equal(tap.take()["sequence"], numpy.arange(10, 13))

    def test_an_array_is_the_programs_own(self):
        with tactor.Session(WALL, duration="1 s") as session:
            tap = session.tap("device.commanded")
            session.advance("0.5 s")
            first = tap.take()
            kept = first.copy()
            session.run()
            tap.take()["force"][:] = 0
            numpy.testing.assert_array_equal(first, kept)

    def test_a_tap_outlives_its_session_with_what_came_last(self):
        session = tactor.Session(WALL, duration="1 s")
        tap = session.tap("device.commanded")
        session.advance("0.2 s")
        session.finish()
        del session
        gc.collect()
        self.assertEqual(len(tap.take()), 200)
        self.assertEqual(len(tap.take()), 0)

    def test_a_tap_ends_with_its_object(self):
        with tactor.Session(WALL, duration="1 s") as session:
            tap = session.tap("device.commanded")
            session.advance("0.1 s")
            del tap
            session.advance("0.1 s")
            late = session.tap("device.commanded")
            session.advance("0.1 s")
            self.assertEqual(late.take()["sequence"][0], 200)


class Feeds(PackageTest):
    STILL = {"R_WH": [1, 0, 0, 0], "v_WH": [0, 0, 0], "w_WH": [0, 0, 0]}

    def fed(self):
        return tactor.Session(WALL, duration="1 s", feeds=["device.target"])

    def test_what_is_sent_arrives_as_it_was(self):
        with self.fed() as session:
            feed, tap = session.feed("device.target"), session.tap(next(o for o in session.graph.outputs if "feed" in o or "target" in o))
            session.start()
            self.assertTrue(feed.send(p_WH=[0.1, 0.2, 0.3], **self.STILL))
            session.advance("10 ms")
            value = numpy.zeros((), feed.dtype)
            value["p_WH"], value["R_WH"] = [1, 2, 3], [1, 0, 0, 0]
            self.assertTrue(feed.send(value, valid="9 ms"))
            session.advance("10 ms")
            sent = tap.take()
            numpy.testing.assert_array_equal(sent["p_WH"], [[0.1, 0.2, 0.3], [1, 2, 3]])
            numpy.testing.assert_array_equal(sent["valid_ns"], [0, 9_000_000])
            numpy.testing.assert_array_equal(sent["produced_ns"], [0, 10_000_000])
            self.assertTrue(feed.send(sent[0]))  # a row of a tap, with its stamps
            self.assertEqual(feed.units["p_WH"], "m")
            session.advance("1 ms")
            numpy.testing.assert_array_equal(tap.take()["p_WH"], [[0.1, 0.2, 0.3]])

    def test_the_handle_goes_where_it_is_led(self):
        with self.fed() as session:
            feed, tap = session.feed("device.target"), session.tap("device.state")
            session.start()
            for i in range(100):
                feed.send(p_WH=[0, 0, 0.1 + 1e-4 * i], **self.STILL)
                session.advance("1 ms")
            self.assertAlmostEqual(tap.take()["p_WD"][-1, 2], 0.11, delta=1e-3)

    def test_what_does_not_fit_is_refused_with_the_field(self):
        with self.fed() as session:
            feed = session.feed("device.target")
            session.start()
            whole = {"p_WH": [0, 0, 0], **self.STILL}
            for value, said in [
                    (3, "expected a dict or one structured element"),
                    (numpy.zeros(3), "expected a dict or one structured element"),
                    (numpy.zeros(2, feed.dtype), "expected a dict or one structured element"),
                    (numpy.zeros((), [("x", float)]), "found a field x"),
                    ({**whole, "more": 1}, "found a field more"),
                    ({"p_WH": [0, 0, 0]}, "found none named R_WH"),
                    ({**whole, "p_WH": [0, 0]}, "p_WH: expected the shape (3,), found (2,)"),
                    ({**whole, "p_WH": 1.0}, "p_WH: expected the shape (3,), found ()"),
                    ({**whole, "p_WH": ["a", "b", "c"]}, "p_WH: expected float64 (m)"),
                    ({**whole, "p_WH": [1j, 0, 0]}, "p_WH: expected float64 (m)"),
                    ({**whole, "p_WH": None}, "p_WH: expected float64 (m)"),
                    ({**whole, "p_WH": [[0, 0], [0]]}, "p_WH: expected float64 (m)"),
            ]:
                with self.subTest(value=value):
                    self.assertIn(said, self.refused(tactor.InputError, feed.send, value))
            self.refused(TypeError, feed.send)
            self.assertIn("valid", self.refused(tactor.InputError, feed.send, whole, valid="3 kg"))

    def test_what_would_lead_a_reader_out_of_an_array_is_refused(self):
        with tactor.Session(WALL, duration="1 s", feeds=["dynamics.contacts"]) as session:
            feed = session.feed("dynamics.contacts")
            session.start()
            for field, wrong in (("count", 2_000_000), ("count", -1), ("bodies.count", 1000), ("pair.body", -1)):
                value = numpy.zeros((), feed.dtype)
                value["count"] = 1
                inner, _, last = field.rpartition(".")
                (value[inner] if inner else value)[last] = wrong
                with self.subTest(field=field, wrong=wrong):
                    self.assertRegex(self.refused(tactor.InputError, feed.send, value), rf"ContactSet\..*{last}: expected")
                    self.assertRegex(self.refused(tactor.InputError, feed.send, {name: value[name] for name in feed.dtype.names}),
                                     rf"ContactSet\..*{last}: expected")
            self.assertTrue(feed.send(numpy.zeros((), feed.dtype)))
            session.advance("100 ms")

    def test_a_parameter_changes_while_the_run_goes_on(self):
        with tactor.Session(WALL, duration="1 s") as session:
            tap = session.tap("coupling.parameters")
            session.advance("0.2 s")
            session.set("coupling.k_0", "1234 N/m")
            session.advance("0.5 s")
            self.assertAlmostEqual(tap.take()["k_t"].max(), 1234, delta=1234 * 0.5)
            said = self.refused(tactor.InputError, session.set, "coupling.k_0", "3 kg")
            self.assertIn("expected a stiffness (N/m), found 3 kg", said)
            self.assertIn('did you mean "coupling.k_0"', self.refused(tactor.InputError, session.set, "coupling.k0", 1))


class Misuse(PackageTest):
    def test_calls_that_the_state_does_not_allow_raise(self):
        session = tactor.Session(WALL, duration="1 s", feeds=["device.target"])
        feed = session.feed("device.target")
        self.refused(tactor.RunError, session.set, "coupling.k_0", 100)
        self.refused(tactor.RunError, session.stop)
        self.refused(tactor.RunError, feed.send, p_WH=[0, 0, 0], **Feeds.STILL)
        self.refused(tactor.InputError, session.status)
        session.start()
        self.refused(tactor.RunError, session.start)
        session.advance("0.1 s")
        session.finish()
        session.finish()
        for call in (session.start, session.stop, lambda: session.advance(1), lambda: session.set("coupling.k_0", 100),
                     lambda: session.tap("device.state"), lambda: session.feed("device.target"),
                     lambda: feed.send(p_WH=[0, 0, 0], **Feeds.STILL)):
            self.assertIn("finished", self.refused(tactor.RunError, call))
        self.assertEqual((session.now, session.running), (0.1, False))
        self.assertEqual(session.metrics["dynamics_damped_steps"], 0)
        del session
        gc.collect()
        self.assertIn("gone", self.refused(tactor.RunError, feed.send, p_WH=[0, 0, 0], **Feeds.STILL))

    def test_it_counts_as_running_from_its_beginning_to_its_end(self):
        with tactor.Session(WALL, duration="0.05 s") as session:
            rounds = 0
            while session.running:
                session.advance("10 ms")
                rounds += 1
            self.assertEqual((rounds, session.now), (5, 0.05))

    def test_a_session_that_never_starts_ends(self):
        with tactor.Session(WALL) as session:
            session.tap("device.state")
        self.assertFalse(session.running)
        self.refused(tactor.RunError, session.start)

    def test_times_and_names_that_are_none(self):
        with tactor.Session(WALL) as session:
            for time in (-1, float("nan"), float("inf"), 1e10, "3 kg", "soon", None, [1]):
                with self.subTest(time=time):
                    self.assertTrue(self.refused(tactor.InputError, session.advance, time).startswith("advance: expected"))
            self.assertIn('did you mean "device.state"', self.refused(tactor.InputError, session.tap, "device.stat"))
            self.assertIn("source.feed", self.refused(tactor.InputError, session.feed, "device.target"))
            for size in (0, -1, (1 << 24) + 1, 1 << 31, 1 << 32, (1 << 63) - 1, 1 << 63, (1 << 64) - 1, 1 << 64, 10**30):
                self.refused(ValueError, session.tap, "device.state", queue=size)
            # What the package hands on is refused there too: products of such sizes wrap.
            for size in ((1 << 24) + 1, 1 << 58, 1 << 63, (1 << 64) - 1):
                self.refused(tactor.InputError, session._session.tap, "device.state", size)
        self.assertIn("pace", self.refused(tactor.InputError, tactor.Session, WALL, pace=-1))
        self.assertIn("pace", self.refused(tactor.InputError, tactor.Session, WALL, pace=1e-9))

    def test_objects_of_the_extension_are_not_made_by_hand(self):
        for kind in (tactor._tactor.Tap, tactor._tactor.Feed, tactor._tactor.RunResult):
            self.refused(TypeError, kind)


class Threads(PackageTest):
    def test_other_threads_go_on_while_a_session_advances(self):
        with tactor.Session(WALL, duration="100 s") as session:
            session.start()
            ended, counted = threading.Event(), [0]

            def advance():
                session.advance("100 s")
                ended.set()
            thread = threading.Thread(target=advance)
            thread.start()
            # A thread that held the interpreter's lock would let this one count once in its whole time.
            while not ended.wait(0.001):
                counted[0] += 1
            thread.join()
        self.assertGreater(counted[0], 50)

    def test_calls_of_several_threads_take_turns(self):
        with tactor.Session(WALL, duration="1000 s") as session:
            tap = session.tap("device.commanded")
            session.start()
            thread = threading.Thread(target=lambda: session.advance("50 s"))
            thread.start()
            sequences = []
            for i in range(200):
                session.set("coupling.k_0", 1000.0 + i)
                sequences.append(tap.take()["sequence"])
            thread.join()
            sequences.append(tap.take()["sequence"])
            numpy.testing.assert_array_equal(numpy.concatenate(sequences), numpy.arange(50_000))
            self.assertEqual(session.now, 50)

    def test_two_sessions_run_at_once(self):
        results = [None, None]

        def run(i):
            try:
                with tactor.Session(WALL, duration="5 s", seed=i + 1) as session:
                    tap = session.tap("device.commanded")
                    session.run()
                    results[i] = numpy.asarray(tap.take())
            except BaseException as error:
                results[i] = error
                raise
        threads = [threading.Thread(target=run, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        at_once = list(results)
        for one in at_once:
            if isinstance(one, BaseException):
                raise one
        for i in range(2):
            run(i)
            numpy.testing.assert_array_equal(at_once[i], results[i])


LIVE = {"clock": "real", "live": {"on_missing_privilege": "warn", "on_stall": "recover"}}


@needs_live
@needs_devices
class HardwareWithoutAButton(PackageTest):
    def test_it_gives_a_force_only_where_the_program_or_the_graph_says_so(self):
        graph = self.write("motor.yaml", "format: 2\nclock: real\nduration: 1 s\nscene: {bodies: {}}\nnodes:\n"
                           "  device: {type: modbus.actuator, profile: iris_orca, connect: \"tcp:127.0.0.1:9\"}\n"
                           "record: [device.state]\n")
        for make in (tactor.Session, tactor.run):
            self.assertRegex(self.refused(tactor.InputError, make, graph),
                             r"motor\.yaml:6:3: nodes\.device: expected a dead-man button, .*no_dead_man=True")
        # Nothing is opened before the start.
        self.assertTrue(tactor.Session(graph, no_dead_man=True).live)
        self.assertTrue(tactor.Session(graph, set={"device.dead_man_button": 0}).live)


@needs_live
class LiveThreads(PackageTest):
    CALLS = ("make", "start", "advance", "stop", "finish")

    def test_each_call_of_a_live_session_may_come_from_another_thread(self):
        """Each call on either of two threads that live on, and once each on a thread of its own: 33 ways."""
        with concurrent.futures.ThreadPoolExecutor(1) as a, concurrent.futures.ThreadPoolExecutor(1) as b:
            own = [concurrent.futures.ThreadPoolExecutor(1) for _ in self.CALLS]
            for way in [*itertools.product((a, b), repeat=len(self.CALLS)), own]:
                make, start, advance, stop, finish = way
                session = make.submit(tactor.Session, WALL, over=LIVE, duration="1000 s").result()
                start.submit(session.start).result()
                advance.submit(session.advance, "30 ms").result()
                stop.submit(session.stop).result()
                finish.submit(session.finish).result()
                self.assertFalse(session.running)
                del session
            for pool in own:
                pool.shutdown()

    def test_a_live_session_is_stopped_beside_the_thread_that_runs_it(self):
        session = tactor.Session(WALL, over=LIVE, duration="1000 s")
        session.start()
        thread = threading.Thread(target=session.run)
        thread.start()
        time.sleep(0.1)
        session.stop()
        thread.join()
        session.finish()
        self.assertLess(session.now, 500)

    def test_a_session_until_stopped_runs_until_a_thread_stops_it(self):
        with tactor.Session(WALL, over=LIVE, duration="until stopped") as session:
            self.assertEqual(session.graph.duration, float("inf"))
            timer = threading.Timer(0.3, session.stop)
            timer.start()
            self.addCleanup(timer.cancel)
            session.start()
            session.run()
            self.assertFalse(session.running)

    def test_a_child_of_the_program_can_end_and_leaves_the_session_alone(self):
        with tactor.Session(WALL, over=LIVE, duration="1000 s") as session:
            session.start()
            child = os.fork()
            if child == 0:
                code = 1
                try:
                    session.stop()
                except tactor.RunError as error:
                    code = 0 if "forked" in str(error) else 2
                del session
                gc.collect()
                os._exit(code)
            self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
            session.advance("50 ms")
            self.assertTrue(session.running)


class Memory(PackageTest):
    def test_a_thousand_sessions_leave_nothing_behind(self):
        graph = self.write("small.yaml", EDGES_OF_A_SMALL_GRAPH + "record: [device.commanded]\n")

        def sessions(count):
            for _ in range(count):
                with tactor.Session(graph, feeds=["device.target"]) as session:
                    tap = session.tap("device.commanded")
                    feed = session.feed("device.target")
                    session.start()
                    feed.send(p_WH=[0, 0, 0], **Feeds.STILL)
                    session.advance("50 ms")
                    self.assertEqual(len(tap.take()), 50)
                try:
                    session.advance(1)
                except tactor.RunError:
                    pass
            gc.collect()
        sessions(200)
        before = resident_MB()
        sessions(1000)
        # A session that stayed would be some 100 kB.
        self.assertLess(resident_MB() - before, 4)

    def test_taps_that_are_gone_leave_nothing_behind(self):
        with tactor.Session(WALL, duration="100 s") as session:
            def taps(count):
                for _ in range(count):
                    tap = session.tap("device.state")
                    session.advance("1 ms")
                    tap.take()
            taps(100)
            before = resident_MB()
            taps(1000)
            # A tap that stayed would be 64 kB or more.
            self.assertLess(resident_MB() - before, 16)


if __name__ == "__main__":
    unittest.main()
