"""Sphinx: the site of the docs. scripts/docs builds it from a copy of the pages (sources.py)."""
import os
import pathlib
import re
import sys

from pygments.lexers.special import TextLexer
from sphinx import addnodes

ROOT = pathlib.Path(os.environ["TACTOR_ROOT"])
sys.path.insert(0, os.environ["TACTOR_PYTHON"])

project = "Tactor"
author = "the authors of Tactor"
copyright = author
version = release = re.search(r"project\(\w+\s+VERSION\s+([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton"]
source_suffix = {".md": "markdown"}
root_doc = "index"
language = "en"
nitpicky = True
# `--jobs` keeps its dashes.
smartquotes = False

myst_heading_anchors = 4
myst_enable_extensions = []

# The Python package: its texts are plain prose. Types of other packages have no page here.
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
default_role = "code"
python_use_unqualified_type_names = True
nitpick_ignore_regex = [("py:.*", r"(numpy|np|npt|pandas|collections|os|pathlib|typing|types|_?[A-Z]\w*)\b.*"),
                        ("py:class", r"tactor\._\w+\..*")]

html_theme = "furo"
html_title = "Tactor"
html_static_path = ["_static", os.environ["TACTOR_STATIC"]]
html_css_files = ["style.css"]
html_favicon = "../images/tactor.svg"
html_extra_path = [os.environ["TACTOR_EXTRA"]]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
# The lines of a page that hold the word are fetched, which browsers refuse to pages of a folder.
html_show_search_summary = False
html_theme_options = {
    "light_logo": "logo.svg",
    "dark_logo": "logo_dark.svg",
    "sidebar_hide_name": True,
    "light_css_variables": {
        "color-brand-primary": "#14507a",
        "color-brand-content": "#1565a0",
        "font-stack": "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif",
        "font-stack--monospace": "ui-monospace, 'Cascadia Mono', 'Source Code Pro', Menlo, Consolas, 'DejaVu Sans Mono', monospace",
    },
    "dark_css_variables": {"color-brand-primary": "#9fc9e6", "color-brand-content": "#6fb7ea"},
}
pygments_style = "friendly"
pygments_dark_style = "github-dark"

# Only commands are copied: no prompt, no output.
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True


def mark_code(app, what, name, obj, options, lines):
    """In the package's texts code is what stands further in."""
    for at in range(len(lines) - 1, 1, -1):
        before = next((line for line in reversed(lines[:at]) if line), "")
        if lines[at].startswith("    ") and not lines[at - 1] and before and not before.startswith(" "):
            lines[at:at] = [".. code-block:: python", ""]


def titles_of(tocs):
    """Of each page's contents the titles, and the pages below it: what the navigation keeps of them."""
    kept = {}
    for page, toc in tocs.items():
        kept[page] = toc.deepcopy()
        for entry in kept[page]:
            if len(entry) > 1:
                below = list(entry.findall(addnodes.toctree))
                entry[1:] = [entry[1].__class__("", *below)] if below else []
    return kept


def navigate_quickly(app, page, template, context, doctree):
    """For every page Sphinx copies the contents of all pages, with all their sections, to throw the sections away."""
    env, whole = app.env, context.get("toctree")
    if whole is None:
        return
    if not hasattr(app, "titles"):
        app.titles = titles_of(env.tocs)

    def toctree(**options):
        contents = env.tocs
        if options.get("titles_only"):
            env.tocs = app.titles
        try:
            return whole(**options)
        finally:
            env.tocs = contents

    context["toctree"] = toctree


def load_from_a_folder(app, pagename, templatename, context, doctree):
    """Browsers take no module from a folder, and scripts/docs makes a plain script of Furo's."""
    for script in context.get("script_files", ()):
        attributes = getattr(script, "attributes", {})
        if attributes.pop("type", None) == "module":
            attributes["defer"] = "defer"


def setup(app):
    app.connect("autodoc-process-docstring", mark_code)
    # Before Furo asks for the navigation.
    app.connect("html-page-context", navigate_quickly, priority=400)
    app.connect("html-page-context", load_from_a_folder, priority=600)
    # Forges draw these; here they are shown as text.
    app.add_lexer("mermaid", TextLexer)
