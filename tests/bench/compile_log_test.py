"""The log of compile times: what counts, and which file of ours an object is of."""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "bench"))
import compile_log  # noqa: E402

PLAN = "framework/graph/CMakeFiles/tactor_graph.dir/plan.cpp.o"
OTHER = "app/CMakeFiles/tactor_app.dir/study/study.cpp.o"


class CompileLog(unittest.TestCase):
    def read(self, text, **options):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
            file.write(text)
            file.flush()
            return compile_log.read(pathlib.Path(file.name), **options)

    def test_the_newest_compilation_counts_and_what_a_cache_answered_does_not(self):
        self.assertEqual(self.read(f"3.5 0.5 {PLAN}\n1.25 0.25 {PLAN}\n0.01 0.02 {PLAN}\n0,50 0,25 {OTHER}\n"), {PLAN: 1.5, OTHER: 0.75})

    def test_objects_that_are_gone_are_left_out_where_the_build_is_known(self):
        with tempfile.TemporaryDirectory() as folder:
            build = pathlib.Path(folder)
            (build / PLAN).parent.mkdir(parents=True)
            (build / PLAN).touch()
            self.assertEqual(self.read(f"1 1 {PLAN}\n9 9 {OTHER}\n", build=build), {PLAN: 2})

    def test_an_object_is_told_by_its_source_and_its_part(self):
        for name, source, part in (
                (PLAN, "framework/graph/plan.cpp", "framework"),
                ("tests/fuzz/CMakeFiles/fuzz_x.dir/__/__/devices/usb/known.cpp.o", "devices/usb/known.cpp", "devices/usb"),
                ("tests/CMakeFiles/test_main.dir/main.cpp.o", "tests/main.cpp", "tests"),
                ("devices/usb/CMakeFiles/nodes_usb.dir/Unity/unity_2_cxx.cxx.o", "devices/usb/nodes_usb, batch 3", "devices/usb"),
                ("nodes/physics/cgal/CMakeFiles/cgal_sources.dir/cmake_pch.hxx.gch", "precompiled headers of cgal_sources",
                 "precompiled headers")):
            self.assertEqual((compile_log.source(name), compile_log.part(name)), (source, part))


if __name__ == "__main__":
    unittest.main()
