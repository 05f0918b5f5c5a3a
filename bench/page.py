"""What the scripts that write pages of results share."""
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parent.parent
KEY = re.compile(r"\{\{(\w+)\}\}")  # a place in a template


def commit():
    """The commit that is checked out, `-dirty` where files differ from it. Ask before measuring: later it may be another."""
    found = subprocess.run(["git", "describe", "--always", "--exclude=*", "--dirty"], cwd=ROOT, capture_output=True, text=True,
                           check=True).stdout.strip()
    if found.endswith("-dirty"):
        print(f"files differ from the commit: the page will say {found}", file=sys.stderr)
    return found


def measured_on():
    """Which commit, when and on what processor: the sentence at the top of a page. Ask before measuring."""
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    return f"Commit {commit()}, {datetime.date.today()}, {model}."


def study(tactor, file, out, *options):
    """study.json of a study file, run into that folder."""
    command = [tactor, "study", file, *options, "--out", out]
    print(" ".join(map(str, command[1:])), flush=True)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return json.loads((out / "study.json").read_text())


def drawn_scenes(folder, seed):
    """The graphs that the generator of scenes draws from a seed into a folder, with their meshes beside them, which are found from then on."""
    subprocess.run([sys.executable, ROOT / "graphs/transfer/make.py", folder, "--seed", str(seed), "--meshes", folder / "meshes"], check=True)
    os.environ["TACTOR_MESH_PATH"] = str(folder / "meshes")
    return sorted(folder.glob("*.yaml"))


def study_text(title, graphs, methods, seeds, first_seed):
    """The text of a study file: files of methods over graphs."""
    return "\n".join(["format: 2", f"title: {title}", "graphs:", *(f"  - {graph}" for graph in graphs), "methods:", *(f"  - {method}" for method in methods),
                      f"seeds: {seeds}", f"first_seed: {first_seed}", ""])


def kept_study(tactor, text, out, jobs, resume):
    """(study.json, the commit that made it) of a study file's text, run into a folder; `resume`: what is there is read."""
    ran_at = out.with_suffix(".commit")
    if not (resume and ran_at.exists()):
        now, file = commit(), out.with_suffix(".yaml")
        file.write_text(text)
        study(tactor, file, out, "--jobs", str(jobs), "--overwrite")
        ran_at.write_text(now)
    return json.loads((out / "study.json").read_text()), ran_at.read_text()


def versions(packages):
    """{package: version} of Debian's packages that are installed."""
    said = subprocess.run(["dpkg-query", "--show", "--showformat=${Package} ${Version}\n", *packages], capture_output=True, text=True,
                          check=True).stdout
    return dict(line.split() for line in said.splitlines())


def filled(template, values):
    """The template with {{KEY}} replaced by each value. Raises ValueError where a key has no value."""
    for key, value in values.items():
        template = template.replace("{{" + key + "}}", value.rstrip())
    left = KEY.search(template)
    if left:
        raise ValueError(f"the template asks for {left.group()}, which has no value")
    return template


def wrapped(text, indent=""):
    """The text in lines of at most 120 characters; the indent comes before all but the first."""
    return textwrap.fill(text, 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def is_run_time(name):
    """Whether a metric of a study is a run time."""
    return name.startswith(("cpu_", "method_us_", "cost_us."))


def timing(found):
    """How the run times of a study were taken, and what its report warns of, from study.json."""
    said = found["timing"]
    return wrapped(said["text"] + (f" **{said['warning']}**" if said["warning"] else "")) + "\n"


def page_file(name):
    """docs/NAME.md, and README.md beside docs for "README"."""
    return ROOT / "README.md" if name == "README" else ROOT / f"docs/{name}.md"


def write(name, values, template=""):
    """Writes docs/FOLDER/NAME.md, for "FOLDER/NAME", from scripts/NAME.template.md, or from that of another name."""
    template = ROOT / f"scripts/{template or pathlib.Path(name).name}.template.md"
    page_file(name).write_text(filled(template.read_text(), values))
    print(f"docs/{name}.md")


def around(text, block):
    """What stands before, in and after the block <!-- BLOCK: begin --> ... <!-- BLOCK: end -->. Raises ValueError where there is none."""
    begin, end = f"<!-- {block}: begin -->", f"<!-- {block}: end -->"
    if begin not in text or end not in text:
        raise ValueError(f"there is no block {block}")
    return text[:text.index(begin) + len(begin)], text[text.index(begin) + len(begin):text.index(end)], text[text.index(end):]


def block(name, block):
    """What stands in a block of a page, which another script writes."""
    return around(page_file(name).read_text(), block)[1].strip()


def write_block(name, block, text):
    """Replaces what stands in a block of a page."""
    file = page_file(name)
    before, _, after = around(file.read_text(), block)
    file.write_text(f"{before}\n{text.strip()}\n{after}")
    print(f"{file.relative_to(ROOT)}, {block}")
