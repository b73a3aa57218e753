"""The report: what a lighting engineer hands over, as one HTML file that prints well."""

import datetime
import os
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from radiosity.scene.model import Camera, Scene
from radiosity.transport.files import check_place, written_whole
from radiosity.transport.threads import Progress, silent

if TYPE_CHECKING:
    from radiosity.solve.solution import Solution
    from radiosity.view.report.figures import Figures

MOST_PICTURES, LONGEST = 4, 640  # cameras, and pixels of a picture, where none are named


def report(
    solution: "Solution",
    path: str | PathLike | None,
    *,
    cameras: Sequence[str] | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    exposure: float | None = None,
    grids: Sequence[str | float] = (),
    spacing: float | None = None,
    margin: float | None = None,
    date: str | None = None,
    command: str = "",
    progress: Progress = silent,
) -> "Figures":
    """Write a report of a solution: pictures, illuminance, maps, what was modelled, accuracy.

    Parameters
    ----------
    solution : Solution
    path : str, path or None
        ``.html``; None to write nothing and only have the figures.
    cameras : list of str, optional
        By name; the scene's first four if not given.
    size : (w, h), optional
        Pixels of the pictures; the cameras' own, at most 640, if not given.
    samples : int, optional
        Rays over each pixel's hemisphere, see `radiosity.view.gather.render`.
    exposure : float, optional
        Display value per radiance of the pictures, instead of the automatic one.
    grids : list of str or float, optional
        Heights of planes and names of surfaces, as ``probe --grid`` takes them. If not given, the
        floor and, of a room, the work plane 0.75 m above its lowest point, the height of a desk.
    spacing, margin : float, optional
        Of these grids, scene units; as EN 12464-1 wants them if not given.
    date : str, optional
        ISO 8601, as 2026-12-31; if not given that of ``SOURCE_DATE_EPOCH``, or today's.
    command : str
        That made the report, to be told in it.

    Returns
    -------
    Figures
        All numbers of the report; ``as_dict()`` for JSON.

    Raises
    ------
    ValueError
        Another suffix, a date that is none, an unknown camera, an impossible grid or size.
    OSError
        Where the file cannot be written.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/furnace.toml"), accuracy=0.1)
    >>> told = radiosity.report(solution, "furnace.html", size=(16, 12), samples=8)
    >>> round(told.grids[0].found.mean, 1)  # lx on the work plane
    2258.7
    """
    from radiosity.solve.solution import refuse_unsolved

    refuse_unsolved(solution)
    day = date_of(date)
    if path is not None:
        check_path(path)
    chosen = cameras_of(solution.scene, cameras)
    from radiosity.view.report.figures import gather

    named = (grids,) if isinstance(grids, str | float | int) else grids
    figures = gather(solution, day, tuple(map(str, named)), spacing, margin, command)
    if path is None:
        return figures
    from radiosity.view.camera import fitting

    views = [(camera, size or fitting(camera, LONGEST)) for camera in chosen]
    return _write(solution, path, figures, views, samples, exposure, progress)


def date_of(text: str | None) -> str:
    """Return a day as ISO 8601 has it: the one given, ``SOURCE_DATE_EPOCH``'s, or today."""
    if text is not None:
        try:
            return datetime.date.fromisoformat(text).isoformat()
        except ValueError:
            raise ValueError(
                f"date = {text!r} must be a day as ISO 8601 has it, such as 2026-12-31"
            ) from None
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch is None:
        return datetime.date.today().isoformat()
    try:
        return datetime.datetime.fromtimestamp(int(epoch), datetime.UTC).date().isoformat()
    except (ValueError, OverflowError, OSError):
        raise ValueError(
            f"SOURCE_DATE_EPOCH = {epoch!r} must be a number of seconds since 1970: unset it, or "
            "give a date"
        ) from None


def check_path(path: str | PathLike) -> None:
    """Refuse a file that is no .html, or a place where none can be written."""
    suffix = Path(path).suffix.lower()
    if suffix != ".html":
        raise ValueError(
            f"report {str(path)!r} has the suffix {suffix!r}; supported is .html, which any "
            "browser prints to PDF"
        )
    check_place(path)


def cameras_of(scene: Scene, names: Sequence[str] | None) -> list[Camera]:
    """Return the cameras to be shown: those named, or the first few."""
    from radiosity.view.gather import find_camera

    if names is None:
        return list(scene.cameras.values())[:MOST_PICTURES]
    return [find_camera(scene, name) for name in names]


def _write(solution, path, figures, views, samples, exposure, progress) -> "Figures":
    """Write the file; return the figures with those of its pictures."""
    from radiosity.view.gather import render
    from radiosity.view.report.chart import draw
    from radiosity.view.report.figures import Pictured
    from radiosity.view.report.maps import map_of
    from radiosity.view.report.page import page

    with written_whole(path) as temporary:
        pictures = [
            render(solution, camera, size=size, samples=samples, progress=progress)
            for camera, size in views
        ]
        if exposure is not None:
            pictures = [replace(image, exposure=exposure) for image in pictures]
        told = tuple(
            Pictured(camera.name, *size, image.exposure, image.noise)
            for (camera, size), image in zip(views, pictures, strict=True)
        )
        figures = replace(figures, pictures=told)
        maps = [
            (zone, draw(map_of(solution, zone))) for zone in figures.grids if zone.where is not None
        ]
        temporary.write_text(page(figures, pictures, maps), encoding="utf-8")
    return figures
