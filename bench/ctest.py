"""What ctest runs in a build, as it tells."""
import json
import pathlib
import subprocess
import typing

ROOT = pathlib.Path(__file__).resolve().parent.parent


class Test(typing.NamedTuple):
    name: str
    folder: str  # that declares it, from the top of the sources
    labels: list
    command: list
    environment: dict
    where: str  # the folder in which it runs


def tests(build):
    """Of a build's folder."""
    said = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], check=True, stdout=subprocess.PIPE, text=True).stdout)
    graph = said["backtraceGraph"]
    for test in said["tests"]:
        properties = {one["name"]: one["value"] for one in test.get("properties", ())}
        node, files = test["backtrace"], []
        while node is not None:
            files.append(graph["files"][graph["nodes"][node]["file"]])
            node = graph["nodes"][node].get("parent")
        folder = next(pathlib.Path(file).parent for file in files if file.endswith("CMakeLists.txt"))
        yield Test(test["name"], folder.relative_to(ROOT).as_posix(), properties.get("LABELS", []), test["command"],
                   dict(one.split("=", 1) for one in properties.get("ENVIRONMENT", ())), properties["WORKING_DIRECTORY"])
