"""Run one form-factor program on one mesh, in a process of its own, and see what it takes.

    PYTHON benchmarks/peers.py NAME IN.npz OUT.npz SETTING

NAME is a function in `DRIVERS`, PYTHON any interpreter that has its package and numpy; IN holds
`vertices` and `faces` (quads), OUT gets `factors` (F[i, j] from i to j), the seconds and the
megabytes. What a package compiles and imports is left out of the seconds, not of the megabytes.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

import numpy as np

# Runs of ours and of View3D are repeated until they are so many, or take so many seconds and are
# at least FEWEST; none is begun after PATIENCE.
MOST, ENOUGH, FEWEST, PATIENCE = 9, 3.0, 3, 30.0
# A tiny interpreter between: a child's peak counts what its parent held when it was started.
LAUNCHER = """
import json, os, subprocess, sys, time
begun = time.perf_counter()
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, used = os.wait4(child.pid, 0)
print(json.dumps({"seconds": time.perf_counter() - begun, "cpu": used.ru_utime + used.ru_stime,
                  "megabytes": used.ru_maxrss / 1024, "status": status}))
"""


class Failed(Exception):
    """A program has no result; the message is short enough for the table."""


@dataclass
class Run:
    """What a program answered and what it took; `raw_closure` where the factors are repaired."""

    factors: np.ndarray
    seconds: float
    cpu: float
    megabytes: float
    raw_closure: np.ndarray | None = None
    version: str = ""


@dataclass
class Clock:
    """Wall and CPU seconds of calls, and the process's peak memory after the first."""

    seconds: list = field(default_factory=list)
    cpu: list = field(default_factory=list)
    megabytes: float = 0.0

    @property
    def enough(self):
        done, total = len(self.seconds), sum(self.seconds)
        return done >= MOST or total > PATIENCE or (done >= FEWEST and total > ENOUGH)

    def time(self, function):
        wall, cpu = time.perf_counter(), time.process_time()
        result = function()
        self.seconds.append(time.perf_counter() - wall)
        self.cpu.append(time.process_time() - cpu)
        self.megabytes = self.megabytes or peak_megabytes()
        return result


def peak_megabytes():
    """Return the peak memory of this process (from Linux's own book, see `LAUNCHER`)."""
    try:
        status = Path("/proc/self/status").read_text()
        return int(status.split("VmHWM:")[1].split()[0]) / 1024
    except (OSError, IndexError):
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2  # bytes on macOS


def two_boxes():
    """Return a closed box with another inside: 12 quads that exercise a program's every path."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    inward = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4],
                       [1, 5, 7, 3]])  # fmt: skip
    return np.r_[corner, 0.3 + 0.4 * corner], np.r_[inward, 8 + inward[:, ::-1]]


def ours(vertices, faces, setting, clock):
    import radiosity

    accuracy = float(setting)
    radiosity.form_factors(two_boxes(), accuracy=min(accuracy, 1e-3))
    while not clock.enough:
        found = clock.time(lambda: radiosity.form_factors((vertices, faces), accuracy=accuracy))
    return {"factors": found.toarray(), "raw_closure": found.raw_closure}


def pyviewfactor(vertices, faces, setting, clock):
    import pyviewfactor as pvf
    import pyvista

    def solve(vertices, faces):
        quads = np.insert(faces, 0, 4, axis=1).ravel()
        mesh = pyvista.PolyData(vertices, quads)
        return pvf.compute_viewfactor_matrix(mesh, obstacles=[mesh])

    solve(*two_boxes())
    return {"factors": clock.time(lambda: solve(vertices, faces)).T}  # its F[i, j] is from j to i


def raystrack(vertices, faces, setting, clock):
    import raystrack as rs

    accuracy = rs.Accuracy(max_replicates=int(setting), min_replicates=int(setting))

    def solve(vertices, faces):
        vertices = vertices / np.ptp(vertices, axis=0).max()  # its rays are so many a unit of area
        halves = np.array([[0, 1, 2], [0, 2, 3]])
        meshes = {str(i): rs.Mesh(vertices[q], halves) for i, q in enumerate(faces)}
        scene = rs.Scene.from_meshes(meshes)
        with rs.Solver(scene, device="cpu", bvh="builtin") as solver:  # its choice from 256 quads
            return solver.solve(rs.Query.matrix(), rs.SolveOptions(accuracy=accuracy))

    solve(vertices, faces[:100])  # so many that all it uses is compiled
    result = clock.time(lambda: solve(vertices, faces))
    factors, dense = np.zeros((len(faces), len(faces))), result.dense()
    for column, channel in enumerate(result.channels):
        if channel.kind == "surface" and channel.side == "front":
            factors[:, int(channel.surface_id)] = dense[:, column]
    return {"factors": factors}


DRIVERS = {"radiosity": ours, "pyviewfactor": pyviewfactor, "raystrack": raystrack}


def drive(name, source, target, setting):
    mesh, clock = np.load(source), Clock()
    result = DRIVERS[name](mesh["vertices"], mesh["faces"], setting, clock)
    np.savez(target, seconds=np.median(clock.seconds), cpu=np.median(clock.cpu),
             megabytes=clock.megabytes, version=version(name), **result)  # fmt: skip


def run_python(name, mesh, setting, python, timeout):
    """Return the Run of a Python package in the interpreter `python`.

    Raises
    ------
    Failed
        Where the package is missing, fails, or takes longer than `timeout` seconds.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.npz"), Path(folder, "out.npz")
        np.savez(source, vertices=mesh.vertices, faces=mesh.faces)
        _call([python, __file__, name, source, target, str(setting)], timeout)
        with np.load(target) as found:
            scalars = {k: found[k].item() for k in ("seconds", "cpu", "megabytes", "version")}
            raw = found["raw_closure"] if "raw_closure" in found else None
            return Run(found["factors"], raw_closure=raw, **scalars)


def run_view3d(mesh, setting, program, timeout):
    """Return the Run of View3D: defaults (raw factors, encl=0), eps = `setting`.

    Its binary output is read (out=1): the text has six decimals, too few for small patches.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.vs3"), Path(folder, "out.vf")
        source.write_text(_view3d_input(mesh, setting))
        command = [sys.executable, "-S", "-c", LAUNCHER, program, source, target]
        clock = Clock()
        while not clock.enough:
            target.unlink(missing_ok=True)
            used = json.loads(_call(command, timeout, cwd=folder))
            if used["status"] or not target.exists():
                raise Failed("failed")
            clock.seconds.append(used["seconds"])
            clock.cpu.append(used["cpu"])
        return Run(
            seconds=np.median(clock.seconds), cpu=np.median(clock.cpu),
            megabytes=used["megabytes"], **_view3d_output(target.read_bytes()),
        )  # fmt: skip


def _call(command, timeout, **options):
    """Return what a command prints; kill it, with what it started, when it takes too long."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          start_new_session=True, **options) as child:  # fmt: skip
        try:
            out, err = child.communicate(timeout=timeout)
        except BaseException as stopped:
            os.killpg(child.pid, signal.SIGKILL)
            if isinstance(stopped, subprocess.TimeoutExpired):
                raise Failed(f"not in {timeout:g} s") from None
            raise
    if child.returncode:
        last = err.strip().splitlines()[-1] if err.strip() else f"exit {child.returncode}"
        missing = "ModuleNotFoundError" in last or "has no attribute 'form_factors'" in last
        raise Failed("not installed" if missing else f"failed: {last[:80]}")
    return out


def _view3d_input(mesh, eps):
    lines = ["T form factors", f"C eps={eps} out=1", "F 3"]
    lines += [f"V {i} {x:.9g} {y:.9g} {z:.9g}" for i, (x, y, z) in enumerate(mesh.vertices, 1)]
    lines += [f"S {i} {a} {b} {c} {d} 0 0 0.9 p{i}" for i, (a, b, c, d)
              in enumerate(mesh.faces + 1, 1)]  # fmt: skip
    return "\n".join([*lines, "End of data", ""])


def _view3d_output(content):
    """Read a header of 32 bytes with n last, then float32: n areas, n x n factors, n emittances."""
    header = content[:32].decode("ascii").split()
    n = int(header[-1])
    factors = np.frombuffer(content, np.float32, n * n, 32 + 4 * n).reshape(n, n)
    return {"factors": factors.astype(float), "version": header[1]}


if __name__ == "__main__":
    drive(*sys.argv[1:])
