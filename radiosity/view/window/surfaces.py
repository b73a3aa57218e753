"""The surfaces in the window: in their own colours or in false ones, with lines and edges."""

from typing import TYPE_CHECKING

import numpy as np

from radiosity.view.falsecolour import STEPS, Scale

if TYPE_CHECKING:
    import pyvista

EDGES = "#404448"
DARK = 0.6  # place on the scale from which on lines are dark, being white below
TOWARDS_EYE = -4.0  # depth by which lines are drawn before the surfaces that they lie on
STEEP = 2.0  # pixels, of which a slope's depth is added: lines are as wide on surfaces seen aslant


class Surfaces:
    """A mesh of which a plotter shows one side, the front of its cells.

    Attributes
    ----------
    edges : bool
        Whether the edges of its cells are drawn.
    """

    def __init__(self, plotter: "pyvista.Plotter"):
        """Show nothing as yet."""
        self._plotter, self._actor, self._lines, self._segments = plotter, None, None, None
        self._points = self._cells = self._triangles = self._places = self._facing = None
        self.edges = self._placed = False

    @property
    def actor(self) -> "pyvista.Actor":
        """Return the surfaces as pyvista has them."""
        return self._actor

    def place(self, points: np.ndarray, cells: np.ndarray) -> None:
        """Take a mesh of points (p, 3) and cells as pyvista has them, to be coloured."""
        if points is self._points and cells is self._cells:
            return
        self._points, self._cells, self._triangles = points, cells, None
        self._placed = False

    def paint(self, colours: np.ndarray) -> None:
        """Show display values (p, 3) uint8 of the points, interpolated between them."""
        self._show("colour", colours, rgb=True)
        self._draw_lines(None)

    def map(self, places: np.ndarray, scale: Scale, levels: np.ndarray) -> None:
        """Show where points' values are on a scale of false colours, and lines of equal value.

        Parameters
        ----------
        places : (p,) float64
            Of `Scale.position`, but not clipped: interpolated, then coloured.
        levels : (k,) float64
            Places of the lines.
        """
        table = scale.colours(scale.luminance((np.arange(STEPS) + 0.5) / STEPS))
        self._show(
            "place", places.astype(np.float32), clim=(0.0, 1.0), n_colors=STEPS,
            cmap=_listed(table), interpolate_before_map=True,
        )  # fmt: skip
        self._draw_lines(contours(self._points, self._faces(), places, levels))

    def show_edges(self, shown: bool) -> None:
        """Draw the edges of the cells, or leave them out."""
        self.edges = shown
        self._actor.prop.show_edges = shown

    def follow(self, position: np.ndarray, forward: np.ndarray | None) -> None:
        """Leave out lines on sides that face away from a camera.

        ``position`` (3,) is the camera's; an orthographic one looks ``forward`` from everywhere.
        """
        if self._segments is None:
            return
        ends, normals, _ = self._segments
        ahead = ends[:, 0] - position if forward is None else forward
        self._facing = facing = np.flatnonzero(np.sum(ahead * normals, axis=1) < 0.0)
        pairs = np.column_stack([np.full(len(facing), 2), 2 * facing, 2 * facing + 1])
        self._lines.mapper.dataset.lines = pairs.ravel()
        self._lines.mapper.dataset.cell_data["colour"] = self._segments[2][facing]

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the middles (s, 3) of the lines' segments that face the camera, and their places.

        Places (s,) are those of the levels that `map` was given.
        """
        if self._segments is None:
            return np.zeros((0, 3)), np.zeros(0)
        return self._segments[0][self._facing].mean(axis=1), self._places[self._facing]

    def _faces(self):
        if self._triangles is None:
            self._triangles = triangles_of(self._cells)
        return self._triangles

    def _show(self, name, values, **how):
        import pyvista

        mesh = None if self._actor is None else self._actor.mapper.dataset
        if mesh is not None and self._placed and name in mesh.point_data:
            mesh.point_data[name][:] = values
            mesh.Modified()
            return
        mesh, self._placed = pyvista.PolyData(self._points, faces=self._cells), True
        mesh.point_data[name] = values
        self._actor = self._plotter.add_mesh(
            mesh, scalars=name, name="surfaces", lighting=False, culling="back", edge_color=EDGES,
            line_width=1, reset_camera=False, show_scalar_bar=False, render=False,
            show_edges=self.edges, **how,
        )  # fmt: skip
        self._actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self._actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(STEEP, 0.0)

    def _draw_lines(self, segments):
        """Draw segments as `contours` returns them, or none."""
        import pyvista

        self._plotter.remove_actor("lines", reset_camera=False, render=False)
        self._segments = self._lines = None
        if segments is None or not len(segments[0]):
            return
        ends, normals, places = segments
        colour = np.where(places[:, None] > DARK, np.uint8(20), np.uint8(255)).repeat(3, axis=1)
        both = np.arange(2 * len(ends)).reshape(-1, 2)
        lines = np.column_stack([np.full(len(ends), 2), both]).ravel()
        mesh = pyvista.PolyData(ends.reshape(-1, 3), lines=lines)
        mesh.cell_data["colour"] = colour
        self._lines = self._plotter.add_mesh(
            mesh, scalars="colour", rgb=True, name="lines", lighting=False, line_width=1.5,
            reset_camera=False, show_scalar_bar=False, render=False,
        )  # fmt: skip
        self._lines.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self._lines.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, TOWARDS_EYE)
        self._segments, self._places = (ends, normals, colour), places
        self._facing = np.arange(len(ends))


def triangles_of(cells: np.ndarray) -> np.ndarray:
    """Return (t, 3) the points of triangles as the graphics draw cells: fans from the first."""
    first, begin = 0, []
    while first < len(cells):
        begin.append(first)
        first += cells[first] + 1
    start = np.array(begin, int)
    four = start[cells[start] == 4]
    halves = start[:, None] + [1, 2, 3], four[:, None] + [1, 3, 4]
    return np.concatenate([cells[half] for half in halves])


def contours(
    points: np.ndarray, triangles: np.ndarray, values: np.ndarray, levels: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where linear interpolation in triangles has certain values.

    Parameters
    ----------
    points : (p, 3) float64
    triangles : (t, 3) int
    values : (p,) float64
        At the points.
    levels : (k,) float64

    Returns
    -------
    ends : (s, 2, 3) float64
        Of the segments.
    normals : (s, 3) float64
        Of their triangles, of any length.
    at : (s,) float64
        Their levels.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0]])
    >>> contours(corners, np.array([[0, 1, 2]]), np.array([0.0, 1, 0]), [0.5])[0].tolist()
    [[[1.0, 1.0, 0.0], [1.0, 0.0, 0.0]]]
    """
    ends, normals, at = [], [], []
    for level in levels:
        above = values[triangles] > level
        crossed = triangles[above.any(axis=1) & ~above.all(axis=1)]
        above = values[crossed] > level
        # Turned so that the corner that is alone on its side of the level comes first.
        alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
        turned = np.take_along_axis(crossed, (alone[:, None] + [0, 1, 2]) % 3, axis=1)
        tip, others = turned[:, :1], turned[:, 1:]
        share = (level - values[tip]) / (values[others] - values[tip])
        ends.append(points[tip] + share[..., None] * (points[others] - points[tip]))
        a, b, c = np.moveaxis(points[crossed], 1, 0)
        normals.append(np.cross(b - a, c - a))
        at.append(np.full(len(crossed), level))
    if not ends:
        return np.zeros((0, 2, 3)), np.zeros((0, 3)), np.zeros(0)
    return np.concatenate(ends), np.concatenate(normals), np.concatenate(at)


def _listed(table):
    from matplotlib.colors import ListedColormap

    return ListedColormap(table / 255.0)
