"""Form factors of this package, of pyviewfactor, raystrack and View3D on the same meshes.

    python benchmarks/form_factors.py --peer-python PYTHON --view3d PROGRAM --write

Every run has a process of its own. Seconds are warm and without imports (View3D: its process).
The truth is a closed form (cube), 2^20 rays a surface (rooms, good to 5e-5), and for entries a
run of ours at the accuracy `--reference`. A program that is missing has rows that say so.
"""

import argparse
import platform
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import peers

from radiosity.transport.threads import core_count

HERE = Path(__file__).resolve().parent
# Meshes, the accuracies that are asked of us, and that of the reference run, 0 for none.
ACCURACY = {
    "cube_1536": (1e-2, 3e-3, 1e-3, 5e-5, 3e-5), "room_324": (0.1, 1e-2, 1e-3),
    "room_1296": (0.3, 0.1, 1e-2, 1e-3), "room_5184": (0.3, 0.1),
}  # fmt: skip
REFERENCE = {"cube_1536": 1e-8, "room_324": 1e-4, "room_1296": 1e-4, "room_5184": 0.0}
ADJACENT, OPPOSITE = 0.2000437760754032, 0.1998248956983874  # faces of a cube (Howell C-11, C-14)
VIEW3D = ("1e-4", "1e-6")  # eps; 1e-4 is its default
BRIEF = 20.0  # seconds that room_5184 may take
ROUNDING = 1e-12  # errors below are not told apart
REPLICATES = 5  # raystrack's least; its default (up to 100) takes 20 times as long
LARGEST = {"pyviewfactor": 1600, "raystrack": 400}  # patches; more takes minutes
COLUMNS = (
    "mesh", "program", "s", "CPU s", "MB", "row sums worst", "rms", "repaired worst",
    "surfaces", "surfaces (MC)", "entries rms", "each", "max", "row error", "ours / peer",
)  # fmt: skip
NOTES = """
- s, CPU s: of ours and of View3D the median of 3 to 9 warm runs (fewer where they take over
  30 s together), of other peers one run. MB: peak of the process, imports and all.
- row sums: |sum over j of F_ij - 1| as computed; repaired: the same of what ours hands out.
- surfaces: cube: worst relative error of adjacent / opposite faces against their closed forms;
  rooms: rms error of the 18 x 18 factors between surfaces against the reference run of ours.
  (MC): the same against Monte Carlo, which is itself good to 5e-5.
- entries rms: rms error against the reference run over the rms of that; each (cube): rms of every
  entry's own relative error (absolute where the reference is 0); max: largest absolute error.
- row error: largest sum over j of |error of F_ij|, which is what `accuracy` promises.
- ours / peer: seconds of our fastest run with no error larger than the peer's over the peer's
  seconds, and its accuracy; (MC) is too noisy to count, adjacent and opposite count as one.
- View3D: defaults, one thread, raw factors (encl=0 neither normalises rows nor repairs them),
  binary output; MB no less than the 10 of what starts it. pyviewfactor: defaults, the mesh as
  its own obstacle. raystrack: 5 replicates of 16 cells x 128 rays a patch, mesh scaled to 1 m.
"""


@dataclass(frozen=True)
class Mesh:
    """Quads with the surface that each belongs to; `area` (n,), `normal` (n, 3)."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    surface: np.ndarray
    area: np.ndarray
    normal: np.ndarray

    @classmethod
    def read(cls, name):
        lines = [line.split() for line in (HERE / "meshes" / f"{name}.obj").open()]
        vertices = np.array([line[1:4] for line in lines if line[:1] == ["v"]], float)
        surface = np.cumsum([line[:1] == ["g"] for line in lines]) - 1
        quads = [k for k, line in enumerate(lines) if line[:1] == ["f"]]
        faces = np.array([lines[k][1:] for k in quads], int) - 1
        a, b, c, d = (vertices[faces[:, k]] for k in range(4))
        normal = 0.5 * np.cross(c - a, d - b)
        area = np.linalg.norm(normal, axis=1)
        return cls(name, vertices, faces, surface[quads], area, normal / area[:, None])

    @property
    def is_cube(self):
        return self.name.startswith("cube")

    def pooled(self, factors):
        """Return the factors between surfaces, patches weighted by area."""
        members = np.equal.outer(np.unique(self.surface), self.surface).astype(float)
        exchange = members @ (self.area[:, None] * factors) @ members.T
        return exchange / (members @ self.area)[:, None]


@dataclass
class Row:
    """One run in the table: what it took, or why there is none, and its errors by column."""

    mesh: str
    program: str
    setting: str
    run: peers.Run | None
    problem: str = ""
    errors: dict = field(default_factory=dict)
    accuracy: float | None = None  # of ours

    @property
    def label(self):
        version = self.run.version if self.run and not self.accuracy else ""
        return ", ".join(filter(None, [f"{self.program} {version}".strip(), self.setting]))


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def errors_of(mesh, run, reference):
    """Return the errors of a run by column; those against `reference` only where it is given."""
    repaired = np.abs(run.factors.sum(axis=1) - 1)
    raw = repaired if run.raw_closure is None else np.abs(run.raw_closure)
    found = {"row sums worst": raw.max(), "rms": rms(raw)}
    if run.raw_closure is not None:
        found["repaired worst"] = repaired.max()
    pooled = mesh.pooled(run.factors)
    if mesh.is_cube:
        found["surfaces"] = cube_errors(mesh, pooled)
    else:
        truth = np.loadtxt(HERE / "meshes" / "room_surface_factors.csv", delimiter=",")
        found["surfaces (MC)"] = rms(pooled - truth)
        if reference is not None:
            found["surfaces"] = (rms(pooled - mesh.pooled(reference)),)
    if reference is not None:
        found |= entry_errors(run.factors, reference, mesh.is_cube)
    return found


def cube_errors(mesh, pooled):
    """Return the worst relative errors of adjacent and of opposite faces."""
    _, first = np.unique(mesh.surface, return_index=True)
    cosine = mesh.normal[first] @ mesh.normal[first].T
    adjacent, opposite = pooled[np.abs(cosine) < 0.5], pooled[cosine < -0.5]
    return np.abs(adjacent / ADJACENT - 1).max(), np.abs(opposite / OPPOSITE - 1).max()


def entry_errors(factors, reference, each):
    """Return errors of entries; `each` by itself over those that either run says are not 0."""
    error = factors - reference
    found = {
        "entries rms": rms(error) / rms(reference),
        "max": np.abs(error).max(),
        "row error": np.abs(error).sum(axis=1).max(),
    }
    if each:
        scaled = error / np.where(reference > 0, reference, 1.0)
        found["each"] = rms(scaled[(reference > 0) | (factors > 0)])
    return found


def measured(mesh, program, setting, run, reference, accuracy=None):
    """Return the row of one run; `run` is called here. Factors are not kept."""
    print(f"{mesh.name}: {program} {setting} ...", file=sys.stderr, flush=True)
    try:
        found = run()
    except peers.Failed as problem:
        return Row(mesh.name, program, setting, None, str(problem), accuracy=accuracy)
    errors = errors_of(mesh, found, reference)
    found.factors = found.raw_closure = None
    return Row(mesh.name, program, setting, found, errors=errors, accuracy=accuracy)


def our_rows(mesh, options, reference):
    def row(accuracy):
        return measured(mesh, "radiosity", f"accuracy {accuracy:g}",
                        lambda: ours(mesh, accuracy, options), reference, accuracy)  # fmt: skip

    return [row(accuracy) for accuracy in options.accuracy or ACCURACY[mesh.name]]


def ours(mesh, accuracy, options):
    return peers.run_python("radiosity", mesh, accuracy, sys.executable, options.our_timeout)


def peer_rows(mesh, options, reference):
    def python(name, setting=""):
        if len(mesh.faces) > LARGEST[name]:
            raise peers.Failed(f"not tried over {LARGEST[name]} patches")
        return peers.run_python(name, mesh, setting, options.peer_python, options.timeout)

    def view3d(eps):
        if not options.view3d:
            raise peers.Failed("not installed")
        return peers.run_view3d(mesh, eps, options.view3d, options.timeout)

    runs = [("View3D", f"eps {eps}", lambda eps=eps: view3d(eps)) for eps in VIEW3D]
    runs.append(("pyviewfactor", "", lambda: python("pyviewfactor")))
    runs.append(("raystrack", "", lambda: python("raystrack", REPLICATES)))
    return [measured(mesh, *run, reference) for run in runs]


def reference_of(mesh, options):
    """Return the factors that entries are compared with, None where there are none."""
    accuracy = options.reference[mesh.name]
    if not accuracy:
        return None
    print(f"{mesh.name}: reference, accuracy {accuracy:g} ...", file=sys.stderr, flush=True)
    try:
        return ours(mesh, accuracy, options).factors
    except peers.Failed as problem:
        print(f"  no reference: {problem}", file=sys.stderr)
        return None


def compared(errors):
    """Return the errors that programs are compared by, a number each; not the noisy (MC)."""
    apart = {"repaired worst", "surfaces (MC)"}
    return {name: np.max(value) for name, value in errors.items() if name not in apart}


def fastest(rows, peer, times_better=1.0):
    """Return our fastest row with every error `times_better` below the peer's, None if none."""
    theirs = compared(peer.errors)

    def fits(row):
        found = compared(row.errors)
        return all(found[k] <= max(theirs[k] / times_better, ROUNDING) for k in theirs)

    fitting = [row for row in our_runs(rows, peer.mesh) if fits(row)]
    return min(fitting, key=lambda row: row.run.seconds, default=None)


def our_runs(rows, mesh):
    return [row for row in rows if row.mesh == mesh and row.accuracy and row.run]


def ratio(rows, peer):
    if peer.accuracy or not peer.run or not our_runs(rows, peer.mesh):
        return ""
    best = fastest(rows, peer)
    if best is None:
        return "none as good"
    return f"{best.run.seconds / peer.run.seconds:.2g} ({best.accuracy:g})"


def number(value):
    if value is None:
        return "-"
    return " / ".join(f"{v:.1e}" for v in np.atleast_1d(value))


def cells(row, rows):
    if not row.run:
        return [row.mesh, row.label, row.problem] + [""] * (len(COLUMNS) - 3)
    run = row.run
    took = [f"{run.seconds:.3g}", f"{run.cpu:.3g}", f"{run.megabytes:.0f}"]
    errors = [number(row.errors.get(column)) for column in COLUMNS[5:-1]]
    return [row.mesh, row.label, *took, *errors, ratio(rows, row)]


def table(rows):
    """Return the rows as a Markdown table whose columns line up."""
    lines = [list(COLUMNS), *(cells(row, rows) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    lines.insert(1, ["-" * width for width in widths])
    padded = ([c.ljust(w) for c, w in zip(line, widths, strict=True)] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in padded)


def verdicts(rows):
    """Return what was asked of the package's speed, and what was seen."""
    asked = (
        ("cube_1536", "pyviewfactor", "", 1.0, 50.0),
        ("cube_1536", "View3D", "eps 1e-4", 100.0, 1.0),
        ("room_1296", "View3D", "eps 1e-4", 1.0, 5.0),
    )
    return [*(against(rows, *ask) for ask in asked), large_room(rows)]


def against(rows, mesh, program, setting, times_better, times_faster):
    error = f"errors {times_better:g} times smaller" if times_better > 1 else "no error larger"
    ask = f"{mesh}: {times_faster:g} x as fast as {f'{program} {setting}'.strip()}, {error}"
    peer = find(rows, mesh, program, setting)
    if not peer or not our_runs(rows, mesh):
        return f"- {ask}: not measured"
    best = fastest(rows, peer, times_better)
    if best is None:
        return f"- {ask}: MISSED, no run is as exact"
    seen = peer.run.seconds / best.run.seconds
    verdict = "met" if seen >= times_faster else "MISSED"
    return f"- {ask}: {verdict}, {seen:.3g} x (accuracy {best.accuracy:g})"


def find(rows, *which):
    """Return the row of (mesh, program, setting) if it has a run."""
    return next((r for r in rows if r.run and (r.mesh, r.program, r.setting) == which), None)


def large_room(rows):
    """Take the accuracy that beats View3D's errors on the smaller room, else the finest."""
    ask = f"room_5184: under {BRIEF:g} s at the errors of View3D eps 1e-4 (by room_1296)"
    found = {row.accuracy: row for row in our_runs(rows, "room_5184")}
    peer = find(rows, "room_1296", "View3D", "eps 1e-4")
    best = peer and fastest(rows, peer)
    row = found.get(best.accuracy if best else min(found, default=None))
    if row is None:
        return f"- {ask}: not measured"
    seconds = row.run.seconds
    verdict = "met" if seconds < BRIEF else "MISSED"
    return f"- {ask}: {verdict}, {seconds:.3g} s (accuracy {row.accuracy:g})"


def report(rows, options):
    finest = ", ".join(f"{name} {a:g}" for name, a in options.reference.items() if a)
    machine = (
        f"{platform.machine()} {platform.system()}, {core_count()} cores; reference: {finest}."
    )
    return f"{table(rows)}\n\n{machine}\n\nAsked:\n" + "\n".join(verdicts(rows)) + "\n" + NOTES


def parsed():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--mesh", action="append", choices=ACCURACY, help="only this (repeatable)")
    parser.add_argument("--accuracy", type=float, nargs="+", help="of ours, on every mesh")
    parser.add_argument("--reference", type=float, help="accuracy of our reference; 0: none")
    parser.add_argument("--ours-only", action="store_true", help="no peers")
    parser.add_argument("--peer-python", default=sys.executable, metavar="PATH",
                        help="interpreter that has pyviewfactor and raystrack")  # fmt: skip
    parser.add_argument("--view3d", default=shutil.which("view3d"), metavar="PATH")
    parser.add_argument("--timeout", type=float, default=120.0, help="seconds for a peer")
    parser.add_argument("--our-timeout", type=float, default=1800.0, help="seconds for three of us")
    parser.add_argument("--write", action="store_true", help="write form_factors.md")
    options = parser.parse_args()
    given = {} if options.reference is None else dict.fromkeys(ACCURACY, options.reference)
    options.reference = REFERENCE | given
    return options


def main():
    options, rows = parsed(), []
    for name in options.mesh or ACCURACY:
        mesh = Mesh.read(name)
        reference = reference_of(mesh, options)
        rows += our_rows(mesh, options, reference)
        rows += [] if options.ours_only else peer_rows(mesh, options, reference)
    text = report(rows, options)
    if options.write:
        (HERE / "form_factors.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
