"""Runs the blocks of a page in a folder of its own, as a reader would."""
import contextlib
import fcntl
import functools
import json
import os
import pathlib
import re
import select
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import yaml

from blocks import INSIDE, ROOT, name_of

TACTOR = pathlib.Path(os.environ.get("TACTOR", ROOT / "build/release/bin/tactor")).resolve()
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", TACTOR.parents[1])).resolve()
HERE = pathlib.Path(__file__).resolve().parent
PATIENCE = float(os.environ.get("TACTOR_PATIENCE", 300))  # s, for one command
GRAPH_VERBS = ("run", "compare", "view", "lean", "explain", "check", "graph", "device test", "device calibrate")
# Folders of the clone that commands of a page may name.
CLONE = ("bench", "build", "docs", "examples", "graphs", "meshes", "scripts", "tests")
# What bash has of its own, or what only sets the scene.
BUILT_IN = ("cd", "export", "echo", "source")


class Failed(Exception):
    """A block does not do what its page says."""


def commands_of(text):
    """The commands of a block: (offset of its first line, text); lines that belong together are one."""
    commands, lines, begin, end = [], [], 0, None
    for offset, line in enumerate(text.splitlines()):
        if not lines and not line.strip():
            continue
        begin = begin if lines else offset
        lines.append(line)
        if end is not None:
            if line.strip() != end:
                continue
            end = None
        else:
            document = re.search(r"<<-?\s*['\"]?(\w+)['\"]?", line)
            if document:
                end = document[1]
                continue
        whole = "\n".join(lines)
        if not line.endswith("\\") and subprocess.run(["bash", "-n", "-c", whole], capture_output=True, check=False).returncode == 0:
            if not line.lstrip().startswith("#") or len(lines) > 1:
                commands.append((begin, whole))
            lines = []
    if lines:
        commands.append((begin, "\n".join(lines)))
    return commands


def with_options(command, text):
    """The command, in which each `tactor VERB` has the options of a mark `with VERB OPTIONS`, in the place of its own."""
    verb, _, options = text.partition(" ")
    parts = re.split(rf"(\btactor {re.escape(verb)}\b)", command)
    for name in re.findall(r"--[\w-]+", options):
        parts[2::2] = [re.sub(rf"""^([^;&|]*?) {name}[ =](?:"[^"]*"|'[^']*'|[^\s"']+)""", r"\1", part) for part in parts[2::2]]
    return "".join(f"{part} {options}" if at % 2 else part for at, part in enumerate(parts))


@functools.cache
def help_of(verb):
    """The help of a verb, and whether each of its options takes a value."""
    done = subprocess.run([TACTOR, *verb.split(), "--help"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failed(f"tactor has no verb {verb}")
    options = dict(re.findall(r"^ +(?:-\w,)?(--[\w-]+)(?:\{\w+\})?(?: ([A-Z]+)\b(?!s?:))?", done.stdout, re.MULTILINE))
    return done.stdout, {name: bool(value) for name, value in options.items()}


class PageRunner:
    """One page: its folder, its environment and its Python, which last until it is closed."""

    def __init__(self, page):
        self.page = page
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tactor-docs-")).resolve()
        self.work, home = self.folder / "work", self.folder / "home"
        self.work.mkdir()
        home.mkdir()
        self.state = self.folder / "state"
        self.console = None
        kept = {name: value for name, value in os.environ.items()
                if not name.startswith(("TACTOR_", "XDG_", "PYTHON", "CMAKE_")) and name not in ("TACTOR", "DISPLAY", "WAYLAND_DISPLAY")}
        # What is computed once for all pages is kept where the other tests keep it. Scripts of the clone take TACTOR and TACTOR_BUILD.
        self.environment = kept | {
            "HOME": str(home), "TMPDIR": str(self.folder), "COLUMNS": "120", "MPLBACKEND": "agg", "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONPATH": str(BUILD / "python"), "TACTOR": str(TACTOR), "TACTOR_BUILD": str(BUILD),
            "TACTOR_CACHE": str(BUILD / "tests/cache"), "LC_ALL": "C.UTF-8",
            "PATH": os.pathsep.join([str(TACTOR.parent), "/usr/bin", kept.get("PATH", "")])}

    def close(self):
        if self.console:
            self.console.stdin.close()
            self.console.wait()
            self.console.stdout.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def run(self, block):
        """Does with a block what its language and its marks say; throws `Failed`."""
        fate = block.fate()
        if fate == "not run":
            return
        for command in block.all_marks("first"):
            self.shell(command, block.line - 1)
        if block.mark("file"):
            file = self.work / block.mark("file")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text)
        if fate == "checked" and block.language == "sh":
            for _, command in commands_of(block.text):
                self.check_command(command)
        elif fate == "run":
            {"sh": self.run_shell, "python": self.run_python, "pycon": self.run_python, "cpp": self.compile}[block.language](block)
        elif block.language == "yaml":
            self.check_yaml(block)
        elif block.language == "json":
            try:
                json.loads(block.text)
            except ValueError as error:
                raise Failed(f"no JSON: {error}") from error
        elif block.language == "cmake":
            self.parse_cmake(block)
        for command in block.all_marks("then"):
            self.shell(command, block.line - 1)

    # Shell.

    def run_shell(self, block):
        until, shown = block.mark("until"), False
        commands = commands_of(block.text)
        for text in block.all_marks("with"):
            changed = [(offset, with_options(command, text)) for offset, command in commands]
            if changed == commands:
                raise Failed(f"no command takes '{text}'")
            commands = changed
        for offset, command in commands:
            shown |= self.shell(command, block.line + offset, until)
        if until and not shown:
            raise Failed(f"no command has written '{until}'")

    def link_clone(self, command):
        """The page's folder gets the folders of the clone that a command names."""
        for folder in CLONE:
            if re.search(rf"(?<![\w/.-]){folder}/", command) and not (self.work / folder).exists():
                (self.work / folder).symlink_to(BUILD.parent if folder == "build" else ROOT / folder)

    def shell(self, command, place, until=None):
        """Runs a command; whether it has written `until`, by which it was then ended."""
        self.link_clone(command)
        cwd = self.state.with_suffix(".cwd")
        script = "\n".join([
            f"[ ! -e {self.state} ] || {{ . {self.state}; cd \"$(cat {cwd})\"; }}",
            f"trap 'code=$?; export -p > {self.state}; pwd > {cwd}; exit $code' EXIT", "set -e", command])
        with self.ports_of(command):
            output, code, shown = self.finish(script, until, f"{name_of(self.page)}, line {place}: `{command}`")
        if code != 0 and not (shown and code in (130, -signal.SIGINT)):
            raise Failed(f"{name_of(self.page)}, line {place}: `{command}` ended with {code}:\n{output[-4000:]}")
        return shown

    def finish(self, script, until, what):
        # What reads its standard input waits there, as at a terminal.
        child = subprocess.Popen(["bash", "-c", script], cwd=self.work, env=self.environment, stdin=subprocess.PIPE,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        output, shown, end, again = b"", False, time.monotonic() + PATIENCE, float("inf")
        try:
            while True:
                # What a command leaves in the background may hold the pipe open.
                if select.select([child.stdout], [], [], 0.1)[0]:
                    piece = os.read(child.stdout.fileno(), 65536)
                    output += piece
                    if not piece and child.poll() is not None:
                        break
                    if not piece:
                        time.sleep(0.05)
                elif child.poll() is not None:
                    break
                if until and not shown and until.encode() in output:
                    shown, again = True, time.monotonic() + 0.3
                # A shell that is about to start a command may miss a signal.
                if time.monotonic() > again:
                    again = time.monotonic() + 10
                    os.killpg(child.pid, signal.SIGINT)
                if time.monotonic() > end:
                    raise Failed(f"{what} goes on after {PATIENCE:.0f} s; a mark `until` ends what is meant to:\n"
                                 f"{output.decode(errors='replace')[-4000:]}")
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
            child.stdin.close()
            child.stdout.close()
        return output.decode(errors="replace"), child.returncode, shown

    @contextlib.contextmanager
    def ports_of(self, command):
        """Pages that name the same port wait for each other."""
        ports = set(re.findall(r"--(?:tcp|port|foxglove)[ =](\d{3,5})\b", command))
        if re.search(r"--foxglove(?!=)", command):
            ports.add("8765")
        with contextlib.ExitStack() as held:
            for port in sorted(ports):
                file = held.enter_context(open(f"{tempfile.gettempdir()}/tactor-docs-port-{port}", "w", encoding="utf-8"))
                fcntl.flock(file, fcntl.LOCK_EX)
            yield

    # Commands that are checked and not run.

    def check_command(self, command):
        for part in re.split(r"\s(?:&&|\|\||[;|&])(?:\s|$)", re.sub(r"\\\n", " ", command)):
            words = shlex.split(part, comments=True)
            while words and (re.fullmatch(r"\w+=.*", words[0]) or words[0] in ("sudo", "env", "time")):
                words.pop(0)
            if not words or words[0] in BUILT_IN:
                continue
            if words[0] == "tactor":
                self.check_tactor(words[1:])
            else:
                self.check_program(words)

    def check_tactor(self, words):
        verb = " ".join(words[:2]) if words[0] in ("device", "mesh", "new", "emulate") else words[0]
        text, options = help_of(verb)
        given, values, rest = words[len(verb.split()):], [], []
        while given:
            word = given.pop(0)
            name, _, value = word.partition("=")
            if word == "--":
                self.check_command(shlex.join(given))
                break
            if not name.startswith("-"):
                rest.append(word)
            elif name not in options and not re.search(rf"{re.escape(name)}\b", text):
                raise Failed(f"tactor {verb} has no option {name}")
            else:
                if options.get(name) and "=" not in word:
                    value = given.pop(0)
                if name in ("--over", "--set", "--duration"):
                    values += [name, value]
        if verb in GRAPH_VERBS and rest and not rest[0].endswith(".h5"):
            self.tactor("check", *rest, *values)
        if verb == "study" and rest and not rest[0].startswith("out/"):
            self.begin_study(rest[0], values)

    def check_program(self, words):
        program, options = words[0], [word for word in words[1:] if word.startswith("--")]
        if program == "cmake" and "--preset" in words or program == "ctest" and "--preset" in words:
            presets = json.loads((ROOT / "CMakePresets.json").read_text())
            kind = "testPresets" if program == "ctest" else "buildPresets" if "--build" in words else "configurePresets"
            if words[words.index("--preset") + 1] not in [preset["name"] for preset in presets[kind]]:
                raise Failed(f"CMakePresets.json has no {kind} {words[words.index('--preset') + 1]}")
        elif program.startswith("build/"):
            name = pathlib.Path(program).name
            target = rf"\b{name}\b|\b{name.removeprefix('test_').removeprefix('fuzz_')}\b"
            if not any(re.search(target, file.read_text()) for folder in ("app", "bench", "devices", "tests", "nodes")
                       for file in (ROOT / folder).rglob("CMakeLists.txt")):
                raise Failed(f"no CMakeLists.txt makes {name}")
        elif "/" in program and not program.startswith("/"):
            self.has_options(ROOT / program, options)
        elif shutil.which(program, path=self.environment["PATH"]) is None:
            raise Failed(f"no program {program}")
        for word in words[1:]:
            if re.match(rf"({'|'.join(folder for folder in CLONE if folder != 'build')})/", word) and not (ROOT / word).exists():
                raise Failed(f"{word} does not exist")

    @staticmethod
    def has_options(program, options):
        if not os.access(program, os.X_OK):
            raise Failed(f"{name_of(program)} is not there, or no program")
        text = program.read_text()
        for option in options:
            if f"{option.partition('=')[0]}" not in text:
                raise Failed(f"{name_of(program)} has no option {option}")

    def tactor(self, *words):
        done = subprocess.run([TACTOR, *words], cwd=self.work, env=self.environment, capture_output=True, text=True, check=False,
                              timeout=PATIENCE)
        if done.returncode != 0:
            raise Failed(f"tactor {shlex.join(map(str, words))} ended with {done.returncode}:\n{done.stdout}{done.stderr}")

    def begin_study(self, study, values=()):
        """A study that has read its graphs and made its table is begun; it is ended then. It need not find when its runs are warm."""
        out = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        with subprocess.Popen([TACTOR, "study", study, *values, "--out", out / "out", "--jobs", "1", "--judge", "whole"],
                              cwd=self.work, env=self.environment,
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as child:
            end = time.monotonic() + PATIENCE
            while child.poll() is None and not (out / "out/study.sqlite").exists():
                if time.monotonic() > end:
                    child.kill()
                    raise Failed(f"study {study} has not begun after {PATIENCE} s")
                time.sleep(0.05)
            child.send_signal(signal.SIGINT)
            said = child.stderr.read()
        if not (out / "out/study.sqlite").exists():
            raise Failed(f"study {study}: {said}")

    # Other languages.

    def run_python(self, block):
        if self.console is None:
            self.console = subprocess.Popen([sys.executable, HERE / "console.py"], cwd=self.work, env=self.environment, text=True,
                                            stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.console.stdin.write(json.dumps({"page": name_of(self.page), "line": block.line, "language": block.language,
                                             "text": block.text}) + "\n")
        self.console.stdin.flush()
        answer = self.console.stdout.readline()
        error = json.loads(answer) if answer else "Python ended"
        if error:
            raise Failed(error)

    def compile(self, block):
        text = f'\n#line {block.line} "{name_of(self.page)}"\n{block.text}'
        if block.mark("inside"):
            before, after = (INSIDE / block.mark("inside")).read_text().split("BLOCK;")
            text = f"{before}{text}#line 1 \"after the block\"\n{after}"
        source = self.work / f"block_{block.line}.cpp"
        source.write_text(text)
        done = subprocess.run(["c++", "-std=c++20", "-fsyntax-only", f"-I{self.work}", f"-I{ROOT}", f"-I{BUILD}/generated", "-isystem",
                               "/usr/include/eigen3", source], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Failed(f"does not compile:\n{done.stderr[:4000]}")

    def parse_cmake(self, block):
        """Its syntax; and that the commands of ours are there."""
        listing = self.work / "block.cmake"
        listing.write_text(f"if(FALSE)\n{block.text}endif()\n")
        done = subprocess.run(["cmake", "-P", listing], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Failed(f"no CMake: {done.stderr}")
        ours = "".join(file.read_text() for file in (ROOT / "cmake").iterdir() if file.is_file())
        for name in re.findall(r"\b(tactor_\w+)\(", block.text):
            if f"({name} " not in ours:
                raise Failed(f"the package has no command {name}")

    def check_yaml(self, block):
        try:
            yaml.safe_load(block.text)
        except yaml.YAMLError as error:
            raise Failed(f"no YAML: {error}") from error
        if "../graphs/" in block.text:
            self.link_clone("graphs/")
        file = self.work / (block.mark("file") or f"block_{block.line}.yaml")
        file.write_text(block.text)
        if block.mark("over"):
            self.tactor("check", block.mark("over"), "--over", file)
        elif block.kind() == "graph":
            self.tactor("check", file)
        elif block.kind() == "study":
            self.begin_study(file)
        if not block.mark("file"):
            file.unlink()
