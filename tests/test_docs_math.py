"""Equations of the manual: numbered once, found where they are cited, shown wherever it is read."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted((ROOT / "docs").glob("*.md"))
LAST = {"E": 29, "L": 16}  # of docs/theory.md and docs/light.md
DISPLAYED = re.compile(r"^\$\$\n(.*?)\n\$\$$", flags=re.S | re.M)
INLINE = re.compile(r"\$([^$\n]+)\$")
TAG = re.compile(r"\\tag\{(\w+)\}")
MARK = "\N{INTEGRAL}"  # where a formula was


def formulas(path: Path) -> tuple[list[str], list[str], str]:
    """Return the displayed formulas of a page, those within its lines, and what is left."""
    text = re.sub(r"^```.*?^```|`[^`]+`", "", path.read_text(), flags=re.S | re.M)
    displayed, text = DISPLAYED.findall(text), DISPLAYED.sub("", text)
    return displayed, INLINE.findall(text), INLINE.sub(MARK, text)


def numbers(name: str) -> list[str]:
    """Return the numbers of a page's equations."""
    return [n for shown in formulas(ROOT / "docs" / name)[0] for n in TAG.findall(shown)]


@pytest.mark.parametrize("name, letter", [("theory.md", "E"), ("light.md", "L")])
def test_every_equation_stands_once(name, letter):
    found = numbers(name)
    assert len(found) == len(set(found))
    assert {f"{letter}{k}" for k in range(1, LAST[letter] + 1)} == {
        number for number in found if not number.endswith("a")
    }


def test_cited_equations_exist():
    known = {*numbers("theory.md"), *numbers("light.md")}
    texts = {path: path.read_text() for path in sorted((ROOT / "radiosity").rglob("*.py"))}
    texts |= {path: formulas(path)[2] for path in PAGES}
    cited = [(path.name, number) for path, text in texts.items()
             for number in re.findall(r"\b[EL]\d{1,2}a?\b", text)]  # fmt: skip
    assert len(cited) > 100
    assert [one for one in cited if one[1] not in known] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_markdown_leaves_formulas_alone(page):
    """Renderers differ in what they do to a formula first, so nothing in one is Markdown.

    A backslash before punctuation is an escape, lines that begin like lists, quotes and headings
    become these, and a dollar beside a letter, or a blank within, begins no formula. Lines of text
    that begin with % are comments in MyST.
    """
    displayed, inline, rest = formulas(page)
    assert re.findall(r"^\s*%.*", page.read_text(), flags=re.M) == []
    assert "$" not in rest and not re.search(rf"[\w\\]{MARK}|{MARK}\w", rest)
    for formula in displayed + inline:
        assert not re.search(r"\\[!-/:-@\[-`{-~\n]|\||~", formula), formula
        assert formula.count("{") == formula.count("}"), formula
        assert not re.search(r"^\s*([-+*#]\s|[-=]+$|>|\d+[.)]\s|$)", formula, flags=re.M), formula
    assert [formula for formula in inline if formula != formula.strip()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_formulas_become_mathml(page):
    converter = pytest.importorskip("latex2mathml.converter", reason="part of the extra docs")
    displayed, inline, _ = formulas(page)
    for formula in displayed + inline:
        shown = converter.convert(TAG.sub("", formula), display="block")
        words = "".join(re.findall(r">([^<]*)<", shown))
        assert not re.search(r"[\\{}$^_]", words), f"{formula} shows {words}"
