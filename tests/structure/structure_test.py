"""What may include what, how sources are formatted, and that the documents keep up with the code."""
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "docs/site"))
from sources import links_of, without_code  # noqa: E402

SOURCES = [p for folder in ("framework", "nodes", "devices", "meshes", "app", "python", "tests", "bench")
           for p in sorted((ROOT / folder).rglob("*")) if p.suffix in (".cpp", ".hpp")]
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def includes(path):
    return INCLUDE.findall(path.read_text())


def inside(path, *folders):
    relative = path.relative_to(ROOT).as_posix()
    return any(relative.startswith(folder + "/") for folder in folders)


def code_alone(text):
    """The text with blanks for comments, literals and directives."""
    return re.sub(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|(?m:^ *#[^\n]*)',
                  lambda found: re.sub(r"[^\n]", " ", found[0]), text, flags=re.DOTALL)


def members_of(text):
    """{class: names of its members that may change}, of a source; those are `name_`, neither constant nor a reference."""
    found, classes, statement = {}, [], ""  # of each open brace: the name of its class, or None
    for piece in re.split(r"([{};])", code_alone(text)):
        inside_class = not classes or classes[-1] is not None
        if piece == "{":
            named = re.search(r"\b(?:class|struct)\s+(\w+)(?:\s+final)?\s*(?::[^:].*)?$", re.sub(r"template\s*<[^{]*?>\s*", "", statement), re.DOTALL)
            is_scope = named or re.search(r"\bnamespace\b[^()]*$", statement)
            classes.append((named[1] if named else "") if is_scope and inside_class else None)
            statement = "" if classes[-1] is not None else statement
        elif piece == "}":
            ended = classes.pop()
            if ended is not None or "(" in re.sub(r"<.*>", "", statement):
                statement = ""
        elif piece == ";":
            if inside_class and classes and classes[-1]:
                bare = re.sub(r"=.*", "", re.sub(r"<.*>", "", re.sub(r"\b(public|private|protected):", "", statement), flags=re.DOTALL), flags=re.DOTALL).strip()
                if not re.match(r"(const|static|using|friend|typedef)\b", bare) and not re.search(r"\(|&|\*\s*const\s", bare):
                    found.setdefault(classes[-1], []).extend(re.findall(r"\b\w+_\b(?!\w)", bare))
            statement = "" if inside_class else statement
        elif inside_class:
            statement += piece
    return {name: names for name, names in found.items() if names}


def functions_of(text):
    """(line, lines) of each function of a source, from its name to its closing brace; one within another counts to that."""
    quiet = code_alone(text)
    found, open_braces, begin = [], [], 0  # of each open brace: where its statement begins, or None for a scope; where this statement begins
    for at in re.finditer(r"[{};]", quiet):
        statement = quiet[begin:at.start()]
        if at[0] == "{":
            inside_function = any(one is not None for one in open_braces)
            is_scope = re.search(r"\b(namespace|class|struct|enum|union|extern)\b[^()]*$", statement) or "(" not in statement or statement.rstrip().endswith("=")
            open_braces.append(None if inside_function or is_scope else begin + len(statement) - len(statement.lstrip()))
        elif at[0] == "}":
            start = open_braces.pop()
            if start is not None and re.match(r"\s*[,)({]", quiet[at.end():at.end() + 2]):
                begin = start  # of a member's value before the body of a constructor
                continue
            if start is not None:
                found.append((quiet.count("\n", 0, start) + 1, quiet.count("\n", start, at.start()) + 1))
        begin = at.end()
    return found


class Includes(unittest.TestCase):
    """Dependencies run one way: app -> engine -> graph -> node -> core; nodes and devices -> node, core."""

    def assert_only(self, pattern, *folders):
        """Headers that match are included in these folders alone (and by tests and benchmarks)."""
        for path in SOURCES:
            if inside(path, "tests", "bench", *folders):
                continue
            for header in includes(path):
                with self.subTest(file=path.relative_to(ROOT).as_posix(), header=header):
                    self.assertIsNone(re.match(pattern, header), f"only {folders} may include this")

    def test_each_library_is_included_by_its_owner_alone(self):
        self.assert_only(r"caf/", "framework/engine/live")
        self.assert_only(r"(hdf5|H5)", "framework/record")
        self.assert_only(r"CGAL/", "nodes/physics/cgal", "nodes/physics/meshing", "meshes")
        self.assert_only(r"(suitesparse/|cholmod)", "nodes/physics/suitesparse")
        self.assert_only(r"mujoco/mujoco", "nodes/physics/mujoco")
        self.assert_only(r"yaml-cpp/", "framework/yaml")
        self.assert_only(r"sleef", "framework/math")
        self.assert_only(r"modbus", "devices/modbus")
        self.assert_only(r"libusb", "devices/usb")
        self.assert_only(r"CLI/", "app/verbs")
        self.assert_only(r"sqlite3", "app/study/table")
        self.assert_only(r"openssl/", "app/run")
        self.assert_only(r"boost/(beast|asio)", "app/view/server", "app/bridge", "app/web")
        self.assert_only(r"pybind11/", "python")

    def test_headers_that_take_long_to_compile_are_kept_in_sources(self):
        """Of what takes seconds to read, our headers include none, but for those that only their own folder includes."""
        slow = re.compile(r"(CGAL/|caf/|CLI/|nlohmann/json\.hpp|sqlite3|hdf5|H5|libusb|modbus/|yaml-cpp/|Eigen/(Dense|Eigen)$)")
        behind = {"app/verbs/option_values.hpp", "framework/engine/live/lane_actors.hpp", "framework/engine/live/lane_scheduler.hpp",
                  "framework/record/hdf5_handle.hpp", "nodes/physics/cgal/surface_mesh.hpp"}
        for path in SOURCES:
            name = path.relative_to(ROOT).as_posix()
            if path.suffix != ".hpp" or name in behind or inside(path, "tests", "bench"):
                continue
            for header in includes(path):
                with self.subTest(file=name, header=header):
                    self.assertIsNone(slow.match(header), "include it in a .cpp, and forward what the header names")

    def test_every_program_shows_only_text(self):
        """What a program prints may come from a file or a device: no program writes it to a terminal as it is."""
        programs = [path for path in SOURCES if inside(path, "app", "devices") and re.search(r"^int main\(", path.read_text(), re.MULTILINE)]
        self.assertGreaterEqual(len(programs), 4)
        for path in programs:
            with self.subTest(file=path.relative_to(ROOT).as_posix()):
                body = re.search(r"^int main\([^)]*\) \{\n(.*)\n", path.read_text(), re.MULTILINE)
                self.assertEqual(body[1].strip(), "tactor::show_only_text();")

    def test_escape_sequences_of_ours_are_drawn_on_a_terminal(self):
        for path in SOURCES:
            if inside(path, "tests", "bench") or not re.search(r"\\(x1b|033|e)\[", path.read_text()):
                continue
            with self.subTest(file=path.relative_to(ROOT).as_posix()):
                self.assertIn(path.relative_to(ROOT).as_posix(), ("app/run/live_view.cpp", "app/machine/doctor.cpp"),
                              "write it by draw_on_terminal, the rest as shown_text, and name the file here")

    def test_arrows_run_one_way(self):
        allowed = {
            "framework/core": ("framework/core",),
            "framework/math": (),
            "framework/node": ("framework/core", "framework/node"),
            "framework/yaml": ("framework/core", "framework/yaml"),
            "framework/fields": ("framework/core", "framework/yaml", "framework/fields"),
            "framework/graph": ("framework/core", "framework/fields", "framework/node", "framework/yaml", "framework/graph"),
            "framework/record": ("framework/core", "framework/node", "framework/record"),
            "framework/realtime": ("framework/core", "framework/node", "framework/realtime"),
            "framework/engine": ("framework/core", "framework/fields", "framework/node", "framework/graph", "framework/realtime",
                                 "framework/engine"),
            "framework/session": ("framework",),
            # source.recording plays recordings back through the record interface, which holds no HDF5.
            "nodes/source": ("framework/core", "framework/node", "framework/record", "nodes/source"),
            # Libraries without nodes; each uses those before it.
            "nodes/physics/mesh": ("framework/core", "framework/node", "nodes/physics/mesh"),
            "nodes/physics/mechanics": ("framework/core", "framework/node", "nodes/physics/mesh", "nodes/physics/contact", "nodes/physics/mechanics"),
            "nodes/physics/geometry": ("framework/core", "nodes/physics/mesh", "nodes/physics/geometry"),
            "nodes/physics/contact": ("framework/core", "framework/node", "nodes/physics/mesh", "nodes/physics/geometry",
                                      "nodes/physics/contact"),
            "nodes/physics/deformable": ("framework/core", "framework/node", "nodes/physics/mesh", "nodes/physics/geometry",
                                         "nodes/physics/contact", "nodes/physics/mechanics", "nodes/physics/deformable"),
            "nodes/physics/engine": ("framework/core", "framework/node", "nodes/physics/mechanics", "nodes/physics/engine"),
            "nodes/physics/mujoco": ("framework/core", "framework/node/abi.hpp", "nodes/physics/engine", "nodes/physics/mujoco"),
            "nodes/physics/suitesparse": ("framework/core", "framework/node/abi.hpp", "nodes/physics/deformable", "nodes/physics/suitesparse"),
            "nodes/physics/cgal": ("framework/core", "framework/node/abi.hpp", "nodes/physics/mesh", "nodes/physics/geometry", "nodes/physics/cgal"),
            "nodes/physics/meshing": ("framework/core", "framework/node/abi.hpp", "nodes/physics/mesh", "nodes/physics/cgal",
                                      "nodes/physics/meshing"),
            "nodes/collision": ("framework/core", "framework/node", "nodes/collision", "nodes/physics/mesh",
                                "nodes/physics/geometry", "nodes/physics/contact"),
            "nodes/dynamics": ("framework/core", "framework/node", "nodes/dynamics", "nodes/physics/mechanics",
                               "nodes/physics/mesh", "nodes/physics/geometry", "nodes/physics/contact",
                               "nodes/physics/deformable"),
            "nodes/own_physics": ("framework/core", "framework/node", "nodes/own_physics"),
            "nodes/coupling": ("framework/core", "framework/node", "nodes/coupling", "nodes/physics/mechanics",
                               "nodes/physics/mesh"),
            "nodes/own_physics": ("framework/core", "framework/node", "nodes/own_physics", "nodes/physics/engine",
                                  "nodes/physics/mechanics"),
            "nodes/prediction": ("framework/core", "framework/node", "nodes/prediction", "nodes/physics/contact",
                                 "nodes/physics/engine", "nodes/physics/mechanics"),
            "nodes/interpolation": ("framework/core", "framework/node", "nodes/interpolation", "nodes/physics/contact",
                                    "nodes/physics/engine", "nodes/physics/geometry", "nodes/physics/mechanics"),
            "nodes/passivity": ("framework/core", "framework/node", "nodes/passivity"),
            # A field of forces samples the contacts of the scene, and keeps the device's track and bad samples out as
            # prediction does.
            "nodes/forcefield": ("framework/core", "framework/node", "nodes/forcefield", "nodes/physics", "nodes/prediction"),
            # Effects continue displayed curves as interpolation does. Texture models are files in YAML, read as profiles are.
            "nodes/effect": ("framework/core", "framework/node", "framework/yaml", "nodes/effect",
                             "nodes/interpolation/force_state.hpp"),
            "nodes/experiment": ("framework/core", "framework/node", "nodes/experiment"),
            "nodes/sink": ("framework/core", "framework/node", "nodes/sink"),
            # Devices read their profiles with the errors that graphs have; other nodes than effects read no YAML.
            "devices": ("framework/core", "framework/node", "framework/realtime", "framework/yaml", "devices"),
            # The command knows no device; it asks where profiles lie, and which ports there are.
            # The view also draws meshes and the contacts of the local model, and sends the cursor of device.mouse. `mesh` and `new`
            # look at mesh files, at the way over a surface, and at models of MuJoCo.
            "app": ("framework", "app", "devices/hardware", "devices/mouse/cursor.hpp", "nodes/physics/mesh",
                    "nodes/physics/geometry/tree_distance.hpp", "nodes/physics/contact/local_contacts.hpp",
                    "nodes/physics/engine/mujoco_plugin.hpp"),
            # The Python package runs graphs as the command does, and knows nothing of its words.
            "python": ("framework", "app/run", "app/report", "app/output.hpp", "app/results_folder.hpp", "python"),
            # A session is what every front stands on, and knows none.
            "framework": ("framework",),
            # A study by its steps: what it says, what is to be run, the runs, their table, what is told of it.
            "app/study/spec": ("framework", "app/study/spec"),
            "app/study/plan": ("framework", "app/study/spec", "app/study/plan"),
            "app/study/table": ("framework", "app/run", "app/report", "app/csv_cell.hpp", "app/interruption.hpp",
                                "app/output.hpp", "app/results_folder.hpp", "app/statistics.hpp", "app/study/spec", "app/study/plan",
                                "app/study/table"),
            "app/study/run": ("framework", "app/run", "app/output.hpp", "app/progress_bar.hpp", "app/statistics.hpp",
                              "app/study/spec", "app/study/plan", "app/study/table", "app/study/run"),
            "app/study/report": ("framework", "app/run", "app/report", "app/output.hpp", "app/statistics.hpp", "app/study/spec",
                                 "app/study/plan", "app/study/table", "app/study/report"),
            # A cluster does what one machine does with a study; that knows nothing of it.
            "app/study/cluster": ("framework", "app/run", "app/study", "app/command_output.hpp", "app/interruption.hpp", "app/output.hpp",
                                  "app/progress_bar.hpp", "app/results_folder.hpp", "app/shell_word.hpp"),
        }
        for path in SOURCES:
            for folder, targets in allowed.items():
                if not inside(path, folder):
                    continue
                for header in includes(path):
                    if not header.startswith(("framework/", "nodes/", "devices/", "app/", "meshes/", "python/")):
                        continue
                    with self.subTest(file=path.relative_to(ROOT).as_posix(), header=header):
                        self.assertTrue(header in targets or header.startswith(tuple(t + "/" for t in targets)), f"{folder} may include {targets}")

    def test_nodes_have_no_thread_lock_or_clock_of_their_own(self):
        forbidden = re.compile(r"#include <(thread|mutex|shared_mutex|condition_variable|chrono|ctime|random)>")
        for path in SOURCES:
            if inside(path, "nodes", "devices/simulated"):
                with self.subTest(file=path.relative_to(ROOT).as_posix()):
                    self.assertIsNone(forbidden.search(path.read_text()))


class PrivateNames(unittest.TestCase):
    """The presets `release` and `checked` compile several sources of a library as one, so their unnamed namespaces become one."""

    DEFINITION = re.compile(r"(?!namespace )(?:\[\[\w+\]\] )?(?:[A-Za-z_][\w:<>,&* ]*[ &*])(\w+)(?:\[\w*\])*( = |\{|;|\(([^)]*)\))")
    TYPE = re.compile(r"(?:struct|class|enum class) (\w+)|using (\w+) =")

    def test_they_are_unique_in_a_library(self):
        clashes = []
        for lists in [ROOT / "CMakeLists.txt", *(p for folder in ("framework", "nodes", "devices", "meshes", "app")
                                                 for p in sorted((ROOT / folder).rglob("CMakeLists.txt")))]:
            for sources in re.findall(r"SOURCES\s+((?:[\w/.-]+\.cpp\s*)+)", lists.read_text()):
                owner = {}
                for source in sources.split():
                    for name in self.names_of(lists.parent / source):
                        if owner.setdefault(name, source) != source:
                            clashes.append(f"{lists.parent.relative_to(ROOT)}: {owner[name]} and {source} both define {name[0]}")
        self.assertFalse(clashes, "\n".join(clashes))

    def names_of(self, path):
        """Of a source: what its unnamed namespaces define. Functions that share a name may differ in their parameters."""
        inside_unnamed = False
        names = set()
        for line in path.read_text().splitlines():
            if line.startswith(("namespace {", "}  // namespace")):
                inside_unnamed = line.startswith("namespace {")
            elif inside_unnamed and (match := self.TYPE.match(line) or self.DEFINITION.match(line)):
                parameters = match.group(3) if match.re is self.DEFINITION else None
                types = [re.sub(r"\bconst\b|[&\s]|\w+$", "", p.strip()) for p in parameters.split(",")] if parameters is not None else []
                names.add((match.group(1) or match.group(2), *types))
        return names


class Text(unittest.TestCase):
    def test_sources_are_formatted(self):
        if shutil.which("clang-format") is None:
            self.skipTest("clang-format is not installed")
        # Releases differ in where they put blanks.
        if " version 14." not in subprocess.run(["clang-format", "--version"], capture_output=True, text=True, check=True).stdout:
            self.skipTest("the sources are formatted by clang-format 14, which this is not")
        result = subprocess.run(["clang-format", "--dry-run", "--Werror", *map(str, SOURCES)], capture_output=True,
                                text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr[:2000])

    def test_a_file_can_be_told_in_one_sentence(self):
        for path in SOURCES:
            with self.subTest(file=path.relative_to(ROOT).as_posix()):
                self.assertLessEqual(len(path.read_text().splitlines()), 600)

    def test_a_function_fits_on_a_page(self):
        for path in SOURCES:
            if inside(path, "tests", "bench"):
                continue
            for line, length in functions_of(path.read_text()):
                with self.subTest(function=f"{path.relative_to(ROOT).as_posix()}:{line}"):
                    self.assertLessEqual(length, 80)

    def test_the_lengths_of_functions_are_found(self):
        text = "struct A {\n  int f() const {\n    return 1;  // }\n  }\n};\nA::A()\n    : a_{1},\n      b_(\"}\") {\n  if (a_) {\n  }\n}\n"
        self.assertEqual(functions_of(text), [(2, 3), (6, 6)])

    def test_a_class_has_one_job(self):
        for path in SOURCES:
            if inside(path, "tests", "bench"):
                continue
            for name, members in members_of(path.read_text()).items():
                with self.subTest(name=f"{path.relative_to(ROOT).as_posix()}: {name}"):
                    self.assertLessEqual(len(members), 20, members)

    def test_the_members_of_classes_are_found(self):
        text = """namespace n {
class A final : public B<int> {
 public:
  explicit A(int a) : a_{a} { b_ = {1}; }
  int f() const { int c_ = 1; return c_; }
  struct In { int in_; };
 private:
  const int k_ = 1;
  C& r_;
  int a_, b_ = 2;
  std::map<int, std::function<void(int)>> m_;
  D d_{1, {2}};
  double* const p_;
};
}
"""
        self.assertEqual(members_of(text), {"A": ["a_", "b_", "m_", "d_"], "In": ["in_"]})

    def test_no_promise_stands_where_code_should(self):
        promise = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b")
        for path in SOURCES:
            with self.subTest(file=path.relative_to(ROOT).as_posix()):
                self.assertIsNone(promise.search(path.read_text()))

    def test_every_file_that_names_the_version_names_the_same(self):
        version = re.search(r"^project\(tactor VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
        for name, place in (("CITATION.cff", r"^version: (\S+)$"), ("docs/cite.md", r"^  version = \{(\S+)\},$"), ("docs/changelog.md", r"^## (\S+) ")):
            with self.subTest(file=name):
                self.assertEqual(re.search(place, (ROOT / name).read_text(), re.MULTILINE)[1], version)
        # An earlier version's headers and libraries do not fit, so find_package asks for this one.
        for path in (*ROOT.glob("examples/*/CMakeLists.txt"), *ROOT.glob("docs/*/*.md"), ROOT / "tests/command/build_on_test.py"):
            for asked in re.findall(r"find_package\(tactor (\d\S*?)[ )]", path.read_text()):
                with self.subTest(file=path.relative_to(ROOT).as_posix()):
                    self.assertEqual(asked, ".".join(version.split(".")[:2]))

    def test_former_terms_are_gone(self):
        here = ROOT / "tests/structure"
        gone = [re.compile(line) for line in (here / "gone.txt").read_text().splitlines() if line and not line.startswith("#")]
        # What was renamed is told to whoever uses it, and tested.
        allowed = {"tests/framework/graph/migrate_test.cpp", "tests/command/command_line_test.py"}
        files = [*SOURCES, *ROOT.glob("*.md"), *(p for folder in ("docs", "graphs", "scripts", "tests", "bench", "nodes", "app", "framework")
                                                 for p in sorted((ROOT / folder).rglob("*"))
                                                 if p.suffix in (".py", ".md", ".yaml") or p.name == "CMakeLists.txt")]
        for path in files:
            name = path.relative_to(ROOT).as_posix()
            if name in allowed or inside(path, "tests/structure"):
                continue
            text = path.read_text()
            for pattern in gone:
                found = pattern.search(text)
                with self.subTest(file=name, term=pattern.pattern):
                    self.assertIsNone(found, found and f"line {text[:found.start()].count(chr(10)) + 1}: {found.group(0)}")

    def test_the_page_of_a_scene_names_its_graphs_and_no_others(self):
        scenes = sorted(file.parent for file in (ROOT / "graphs").glob("*/scene.yaml"))
        self.assertGreater(len(scenes), 5)
        for scene in scenes:
            with self.subTest(scene=scene.name):
                page = (scene / "README.md").read_text()
                named = re.findall(r"^\| `([^`]+)` \| \S.* \|$", page, re.MULTILINE)
                self.assertEqual(sorted(named), sorted(file.name for file in scene.glob("*.yaml")))
                self.assertIn("](scene.png)", page)
                self.assertLess((scene / "scene.png").stat().st_size, 150_000)

    def test_links_of_pages_lead_somewhere(self):
        pages = [*ROOT.glob("*.md"), *(page for folder in ("docs", "graphs", "examples", "meshes", "bench", "tests")
                                       for page in sorted((ROOT / folder).rglob("*.md")))]
        self.assertGreater(len(pages), 80)
        anchors = {page: anchors_of(page.read_text()) for page in pages}
        for page in pages:
            for _, _, link in links_of(page.read_text()):
                if re.match(r"[a-z]+:", link):
                    continue
                path, _, anchor = link.partition("#")
                with self.subTest(page=page.relative_to(ROOT).as_posix(), link=link):
                    target = (page.parent / path).resolve() if path else page
                    self.assertTrue(target.exists())
                    if anchor:
                        self.assertIn(anchor, anchors.get(target, ()))

    def test_drawings_are_of_their_sources(self):
        sources = sorted((ROOT / "docs/drawings").glob("*.dot"))
        self.assertEqual({f"drawing_{source.stem}.svg" for source in sources},
                         {picture.name for picture in (ROOT / "docs/images").glob("drawing_*.svg")})
        for source in sources:
            with self.subTest(drawing=source.name):
                checksum = hashlib.sha256(source.read_bytes()).hexdigest()
                self.assertIn(f"SHA-256 {checksum} ", (ROOT / f"docs/images/drawing_{source.stem}.svg").read_text(), "run scripts/drawings")


def anchors_of(text):
    """What GitHub makes of the headings of a page."""
    found = {}
    for line, outside_of_code in zip(text.splitlines(), without_code(text).splitlines()):
        if re.match(r"#{1,6} ", outside_of_code):
            anchor = anchor_of(line)
            found[anchor] = found.get(anchor, -1) + 1
            if found[anchor]:
                found[f"{anchor}-{found[anchor]}"] = 0
    return found


def anchor_of(heading):
    words = re.sub(r"\]\([^)]*\)", "", re.sub(r"[`*\[]", "", heading.lstrip("#").strip())).lower()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


if __name__ == "__main__":
    unittest.main()
