"""What the verbs have in common: load a scene, solve it, say what was found."""

from dataclasses import replace

from radiosity.cli.options import parse_memory, use_threads
from radiosity.cli.progress import remark


def load_scene(path: str, mesh: str, ambient: float, quiet: bool):
    """Return the scene of a file with ambient light, and remark on what was assumed.

    Pairs of triangles are joined to quadrilaterals, but not for ``--mesh input``.
    """
    import numpy as np

    from radiosity.scene.files import load

    if not 0 <= ambient < float("inf"):
        raise ValueError(f"--ambient {ambient} must be a radiance of at least 0 W/(m2 sr)")
    scene = load(path, merge=mesh != "input")
    for note in scene.notes:
        remark(f"note: {note}", quiet)
    if not any(m.emits for m in scene.materials) and ambient == 0:
        remark("note: nothing in the scene emits light; --ambient 1 lets some in", quiet)
    return replace(scene, ambient=np.full(3, float(ambient))) if ambient else scene


def solve_scene(
    scene, accuracy, mesh, solver, seed, memory, threads, quiet, progress, factors=None
):
    """Solve a scene and remark on the result in one line."""
    import time

    from radiosity.solve.solve import solve

    use_threads(threads)
    begun = time.perf_counter()
    solution = solve(
        scene, accuracy, mesh=mesh, solver=solver, seed=seed,
        memory=parse_memory(memory), progress=progress, factors=factors,
    )  # fmt: skip
    seconds = time.perf_counter() - begun
    if solution.solver != solver:
        remark(
            f"note: solved by {solution.solver}: reflectances near 1 make bounces fade slowly",
            quiet,
        )
    remark(
        f"solved {scene.name}: {len(solution.patches)} patches, {len(solution.history)} iterations "
        f"in {seconds:.1f} s",
        quiet,
    )
    return solution
