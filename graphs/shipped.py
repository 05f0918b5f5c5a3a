"""The shipped graphs by the names that runs have, for tests and benchmarks."""
import pathlib

GRAPHS = pathlib.Path(__file__).resolve().parent


def scenes():
    """The folders of scenes."""
    return sorted(folder.parent for folder in GRAPHS.glob("*/scene.yaml"))


def graph_files():
    """All graphs of all scenes."""
    return sorted(file for folder in scenes() for file in folder.glob("*.yaml"))


def graph_name(file):
    """`bunny_refit` of bunny/refit.yaml, `bunny` of bunny/scene.yaml."""
    return file.parent.name if file.stem == "scene" else f"{file.parent.name}_{file.stem}"


def graph_file(name):
    """bunny/refit.yaml of `bunny_refit`."""
    return next(file for file in graph_files() if graph_name(file) == name)
