"""Pages of scenes at 2 % asked: size, time to write and to draw, and how exact their light is.

    python benchmarks/page.py > benchmarks/page.md

Errors are those of illuminances that are interpolated between the page's vertices, as a click reads
them, against what probe tells at 4000 random points, in the norm of the accuracy. Writing takes one
core's seconds; drawing is from the start of loading to the first picture in headless Chromium,
which draws without a graphics card here: the best of three.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tables import begin

import radiosity

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from test_page import Browser  # noqa: E402  what drives it, written once
from test_page_mesh import misses, scattered  # noqa: E402

from radiosity.view.fine.finemesh import gathered_mesh  # noqa: E402
from radiosity.view.page.page import page_of  # noqa: E402

SCENES, COUNT = ("cornell_box", "office", "point_spot"), 4000


def row(name, browser, folder):
    """Return a line of the table for one scene."""
    solution = radiosity.solve(radiosity.load(ROOT / "scenes" / f"{name}.toml"))
    gathered_mesh(solution, most=0)  # compiled
    begun = time.process_time()
    mesh = gathered_mesh(solution, with_errors=True)
    page = folder / f"{name}.html"
    page.write_text(page_of(solution, mesh), encoding="utf-8")
    seconds = time.process_time() - begun
    points, normals, lux = scattered(solution, mesh, COUNT)
    probed = solution.irradiance(points, normals)[0]
    off = 100 * np.percentile(misses(solution, lux, probed), [50, 95, 99])
    drawn = min(browser.open(page) for _ in range(3))
    cells = (
        name, len(solution.patches), len(mesh.points), f"{page.stat().st_size / 1e3:.0f}",
        f"{seconds:.1f}", f"{drawn:.2f}", *(f"{x:.2f} %" for x in off),
    )  # fmt: skip
    return f"| {' | '.join(map(str, cells))} |"


def main():
    begin(__doc__, "scene | patches | vertices | kB | written, s | drawn, s | error, half of the "
          "points below | 95 % | 99 %")  # fmt: skip
    with tempfile.TemporaryDirectory() as profile, tempfile.TemporaryDirectory() as folder:
        browser = Browser(profile)
        try:
            for name in SCENES:
                print(row(name, browser, Path(folder)), flush=True)
        finally:
            browser.driver.quit()


if __name__ == "__main__":
    main()
