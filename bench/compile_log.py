"""What a build wrote of its compilations into build/PRESET/compile_times.txt (cmake/timed_compile)."""
import posixpath
import re

CACHED = 0.05  # s; no file of ours compiles in less


def read(log, build=None):
    """{object: CPU time in s} of the newest compilation of each. Those that ccache answered say nothing and are left out, and
    so are objects that are no longer in the folder `build`, where one is given."""
    times = {}
    for line in log.read_text().splitlines():
        user, system, name = line.replace(",", ".", 2).split(" ", 2)
        if float(user) + float(system) > CACHED and (build is None or (build / name).exists()):
            times[name] = float(user) + float(system)
    return times


def source(name):
    """framework/graph/CMakeFiles/tactor_graph.dir/plan.cpp.o -> framework/graph/plan.cpp; sources that were compiled together
    -> framework/graph/tactor_graph, batch 1"""
    folder, _, rest = name.partition("CMakeFiles/")
    target, _, file = rest.partition("/")
    if file.startswith("cmake_pch"):
        return f"precompiled headers of {target.removesuffix('.dir')}"
    if is_batch(name):
        return f"{folder}{target.removesuffix('.dir')}, batch {int(re.search(r'[0-9]+', file)[0]) + 1}"
    return posixpath.normpath(folder + file.removesuffix(".o").replace("__/", "../"))


def is_batch(name):
    """Whether an object holds several sources, compiled together."""
    return "/Unity/unity_" in name


def part(name):
    """The part of the project that an object is of: framework, nodes, tests/nodes; precompiled headers are one of their own."""
    file = source(name)
    if file.startswith("precompiled headers"):
        return "precompiled headers"
    folders = file.split("/")
    return "/".join(folders[:2]) if folders[0] in ("tests", "bench", "devices") and len(folders) > 2 else folders[0]
