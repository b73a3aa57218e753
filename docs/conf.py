"""The manual: `sphinx-build -W -n -c docs . build/docs` in the project's folder.

The sources are docs/, the tables in benchmarks/ and CHANGELOG.md, where links between them lead on
the code host too. Equations become MathML while the manual is built, so that it needs no network.
"""

import re
import sys
from html import escape
from pathlib import Path

from latex2mathml.converter import convert

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import radiosity  # noqa: E402

project = "radiosity"
author = "the authors of radiosity"
release = version = radiosity.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
include_patterns = ["docs/*.md", "benchmarks/*.md", "CHANGELOG.md"]
root_doc = "docs/index"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
html_math_renderer = "mathml"
html_theme = "furo"
html_title = "radiosity"
html_additional_pages = {"index": "redirect.html"}
templates_path = ["templates"]
html_static_path = ["static"]
html_css_files = ["manual.css"]
html_copy_source = False

default_role = "py:obj"  # of `names` in docstrings
smartquotes = False  # options begin with two dashes
autodoc_preserve_defaults = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings give them, with shapes and units
napoleon_google_docstring = False
napoleon_use_rtype = False
add_module_names = False
# What is not public has no page to lead to: shapes, units, types of numpy.
# radiosity.solve is a room and a function: its page names the function.
nitpick_ignore_regex = [("py:.*", r"(?!radiosity\.(?!solve$)\w+$).*")]

_FUNCTION = re.compile(r"<mi>(sin|cos|tan|ln|log|exp|min|max)</mi>")
_TAG = re.compile(r"\\tag\{(\w+)\}")


def _mathml(latex, **options):
    """Return MathML, with names of functions set apart."""
    return _FUNCTION.sub(r'<mi class="function">\1</mi>', convert(latex, **options))


def _inline(writer, node):
    writer.body.append(_mathml(node.astext()))


def _display(writer, node):
    """Show an equation, its number at the right, which links lead to."""
    text = node.astext()
    tag = _TAG.search(text)
    number = tag[1] if tag else ""
    anchor = f' id="{number}"' if tag else ""
    shown = _mathml(_TAG.sub("", text).strip(), display="block")
    told = f'<span class="eqno">({escape(number)})</span>' if tag else ""
    writer.body.append(f'<div class="equation"{anchor}>{shown}{told}</div>')


def _skip(visit):
    """Return a visitor that is done with a node."""
    from docutils.nodes import SkipNode

    def visitor(writer, node):
        visit(writer, node)
        raise SkipNode

    return visitor


def _entitle(app, document, source):
    """Give a table that a benchmark printed its name as a title."""
    if document.startswith("benchmarks/") and not source[0].lstrip().startswith("# "):
        name = document.removeprefix("benchmarks/").replace("_", " ")
        source[0] = f"# {name.capitalize()}\n\n{source[0]}"


def _plain_bars(app, kind, name, described, options, lines):
    """Keep |x| of docstrings, which would name a substitution."""
    lines[:] = [line.replace("|", r"\|") for line in lines]


def setup(app):
    """Register how equations are shown, and titles of tables."""
    app.connect("autodoc-process-docstring", _plain_bars, priority=900)  # after napoleon
    app.add_html_math_renderer("mathml", (_skip(_inline), None), (_skip(_display), None))
    app.connect("source-read", _entitle)
