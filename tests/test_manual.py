"""Every command and every example of the manual runs, and its links lead somewhere."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import radiosity

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
BIN = Path(sys.executable).parent
BLOCK = re.compile(r"^```(sh|python|toml)\n(.*?)^```", re.S | re.M)
SAVED = re.compile(r"[Ss]ave this as `([\w.]+)`")
# Pictures are made small and of coarse solutions, or of none where solving takes long.
SMALL = {
    "radiosity view": "--size 24x24", "radiosity render": "--size 24x24",
    "radiosity report": "--size 24x24", "radiosity tradeoff": "--size 24x24 --accuracy 0.1",
    "render scenes": "--accuracy 0.1", "report scenes": "--accuracy 0.1",
    "glass_ball": "--method raytrace", "living_room": "--mesh 1", "museum": "--mesh 1",
}  # fmt: skip


def steps(page):
    """Return what a page has the reader do: (kind, text), files to be saved with their names."""
    text, found = page.read_text(), []
    for block in BLOCK.finditer(text):
        before = text[: block.start()].rstrip().splitlines()[-1:]
        name = SAVED.search("".join(before))
        if block[1] == "toml" and name:
            found.append((name[1], block[2]))
        elif block[1] != "toml":
            found.append((block[1], block[2]))
    return found


def shortened(line):
    """Return a command that makes a small picture where it makes one; scripts are run elsewhere."""
    script = re.match(r"python (scenes/\w+\.py)", line)
    if script:
        tested = "".join(p.read_text() for p in (ROOT / "tests").glob("test_*.py"))
        return f"test -f {script[1]}" if Path(script[1]).name in tested else line
    if "--html" in line or "--solvers" in line:
        return line
    line = re.sub(r"--size \S+", "", line.partition("#")[0])
    added = [m for key, m in SMALL.items() if key in line and m.split()[0] not in line]
    return " ".join([line, *added])


def script_of(page):
    """Return a script of all that a page has its reader do, in order."""
    lines = ["import pathlib as _p, subprocess as _s"]
    for kind, text in steps(page):
        if kind == "sh":
            text = "\n".join(map(shortened, text.strip().splitlines()))
        lines.append({
            "python": text,
            "sh": f"_s.run(['bash', '-euc', {text!r}], check=True)",
        }.get(kind, f"_p.Path({kind!r}).write_text({text!r})"))  # fmt: skip
    return "\n".join(lines)


@pytest.mark.parametrize("page", [p for p in PAGES if steps(p)], ids=lambda p: p.stem)
def test_a_reader_can_do_what_the_page_says(page, tmp_path):
    """In a folder with the scenes, block by block; examples in Python go on from each other."""
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    path = os.pathsep.join([str(BIN), os.environ["PATH"]])
    done = subprocess.run(
        [sys.executable, "-c", script_of(page)], cwd=tmp_path, capture_output=True, text=True,
        timeout=600, env={**os.environ, "PATH": path, "DISPLAY": "", "WAYLAND_DISPLAY": ""},
    )  # fmt: skip
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"


def test_commands_stand_where_they_are_run():
    """Not in blocks of text, which only show what is printed."""
    for page in PAGES:
        text = BLOCK.sub("", page.read_text())
        assert not re.search(r"^ {4}(radiosity|python) ", text, re.M), page.name


@pytest.mark.parametrize(
    "page", [*PAGES, ROOT / "README.md", ROOT / "CHANGELOG.md"], ids=lambda p: p.stem
)
def test_links_lead_somewhere(page):
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(#[^)\s]*)?\)", page.read_text()):
        if target.startswith(("http:", "https:")):
            continue
        place = page.parent / target if target else page
        assert place.exists(), f"{page.name}: {target}"
        if anchor:
            heads = re.findall(r"^#+ (.*)$", place.read_text(), re.M)
            slugs = {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in heads}
            tags = set(re.findall(r"\\tag\{(\w+)\}", place.read_text()))
            assert anchor[1:] in slugs | tags, f"{page.name}: {target}{anchor}"


def test_every_page_is_in_the_contents():
    listed = re.findall(r"```\{toctree\}.*?```", (DOCS / "index.md").read_text(), re.S)
    words = set(re.findall(r"^(?:.*<)?([\w./]+)>?$", "\n".join(listed), re.M))
    assert {p.stem for p in PAGES} - {"index"} <= words


def test_every_public_name_is_on_the_page_of_the_api():
    text = (DOCS / "api.md").read_text()
    listed, described = text.split("## Scenes")
    for name in radiosity.__all__:
        assert f"`{name}`" in listed, name
        assert re.search(rf"auto\w+:: radiosity\.(solve\.solve\.)?{name}$", described, re.M), name
