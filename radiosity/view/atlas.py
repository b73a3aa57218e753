"""Atlases by xatlas, in a process of its own.

xatlas (Young, after Microsoft's and Thekla's atlases) works in threads, and now and then crashes
where several processors are busy. A crash must not take the process of the user, and his solution,
along: this file is run as a script that reads meshes and writes their texture coordinates, on one
processor where the system lets it choose, and again if it crashed.
"""

import io
import os
import subprocess
import sys

import numpy as np

CRASHES = 4  # after which it is given up
TRIES, SMALLER = 60, 0.95  # sizes, and each to the one before


def packed(meshes: list[tuple], size: int, padding: int) -> tuple[np.ndarray | None, int]:
    """Return the texture coordinates of meshes, as large as fit into one square.

    Parameters
    ----------
    meshes : list of (places (n, 3) float32, triangles (t, 3) uint32)
    size, padding : int
        Texels on a side, and between charts.

    Returns
    -------
    uv : (t, 3, 2) float64 or None
        Of the triangles of all meshes in order; None where they do not fit.
    charts : int
        How many parts the meshes came to.

    Raises
    ------
    ValueError
        xatlas crashed every time.
    """
    file = io.BytesIO()
    parts = {f"places{k}": places for k, (places, _) in enumerate(meshes)}
    parts |= {f"triangles{k}": triangles for k, (_, triangles) in enumerate(meshes)}
    np.savez(file, size=size, padding=padding, **parts)
    for _ in range(CRASHES):
        # -P: what lies beside this file must not stand in for modules of the same name
        ran = subprocess.run(
            [sys.executable, "-P", __file__], input=file.getvalue(), capture_output=True
        )
        if ran.returncode == 0:
            found = np.load(io.BytesIO(ran.stdout), allow_pickle=False)
            return found["uv"] if found["uv"].size else None, int(found["charts"])
    said = ran.stderr.decode(errors="replace").strip().splitlines()
    raise ValueError(
        f"lightmap: xatlas, which lays the surfaces out, failed {CRASHES} times (exit code "
        f"{ran.returncode}{': ' + said[-1] if said else ''}): save a .glb without a lightmap"
    )


def _main():
    """Read what `packed` sends, and answer."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    given = np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False)
    count = sum(name.startswith("places") for name in given.files)
    meshes = [(given[f"places{k}"], given[f"triangles{k}"]) for k in range(count)]
    uv, charts = _fitted(meshes, int(given["size"]), int(given["padding"]))
    answer = io.BytesIO()
    np.savez(answer, uv=np.empty((0, 3, 2)) if uv is None else uv, charts=charts)
    sys.stdout.buffer.write(answer.getvalue())


def _fitted(meshes, size, padding):
    """Return what `packed` does."""
    scale = 0.0
    for _ in range(TRIES):
        atlas = _atlas(meshes, size, padding, scale)
        if scale == 0.0:
            scale = atlas.texels_per_unit * size / max(atlas.width, atlas.height)
        elif atlas.atlas_count == 1:
            found = [atlas.get_mesh(k) for k in range(len(meshes))]
            return np.concatenate([uv[i] for _, i, uv in found]).astype(float), atlas.chart_count
        else:
            scale *= SMALLER
    return None, atlas.chart_count


def _atlas(meshes, size, padding, scale):
    import xatlas

    options = xatlas.PackOptions()
    options.resolution, options.padding, options.texels_per_unit = size, padding, scale
    options.bilinear = True
    atlas = xatlas.Atlas()
    for places, triangles in meshes:
        atlas.add_mesh(places, triangles)
    atlas.generate(xatlas.ChartOptions(), options)
    return atlas


if __name__ == "__main__":
    _main()
