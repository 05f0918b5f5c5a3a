"""What a build wrote of its compilations into build/PRESET/compile_times.txt (cmake/timed_compile)."""
CACHED = 0.05  # s; no file of ours compiles in less


def read(log):
    """{source: CPU time in s} of the newest compilation of each. Those that ccache answered say nothing and are left out."""
    times = {}
    for line in log.read_text().splitlines():
        user, system, name = line.replace(",", ".").split(" ", 2)
        if float(user) + float(system) > CACHED:
            times[source(name)] = float(user) + float(system)
    return times


def source(name):
    """framework/graph/CMakeFiles/tactor_graph.dir/plan.cpp.o -> framework/graph/plan.cpp"""
    folder, _, rest = name.partition("CMakeFiles/")
    target, _, file = rest.partition("/")
    if file.startswith("cmake_pch"):
        return f"precompiled headers of {target.removesuffix('.dir')}"
    return folder + file.removesuffix(".o").replace("__/", "")


def folder(name):
    """The part of the project that a source is of: framework, nodes, tests/nodes; precompiled headers are one of their own."""
    if name.startswith("precompiled"):
        return "precompiled headers"
    parts = name.split("/")
    return "/".join(parts[:2]) if parts[0] in ("tests", "bench", "devices") and len(parts) > 2 else parts[0]
