"""What all pictures have in common: white page, one camera rule, colours, legend."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.picture.png import write_png

SIZE = (1600, 1200)
SURFACE_COLOR = "#dfe5ec"
FEATURE_COLOR = "#30363d"
_MARGIN = 1.08


class Scene:
    """A pyvista plotter set up for pictures on paper; `save` draws it and closes it."""

    def __init__(self, points: Floats) -> None:
        """The camera takes in all of points (n,3)."""
        import pyvista
        from vtkmodules.vtkCommonCore import vtkLogger

        # without a display VTK warns about X before it takes EGL or OSMesa
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
        self.plotter: Any = pyvista.Plotter(off_screen=True, window_size=SIZE, lighting="none")
        _light(self.plotter)
        self.plotter.set_background("white")
        self.plotter.enable_anti_aliasing("msaa", multi_samples=8)
        self.diagonal = box_diagonal(points)
        self.toward_viewer = _aim(self.plotter.camera, points)
        self._legend: list[tuple[str, str]] = []

    def surface(self, V: Floats, F: Ints, **style: Any) -> None:
        """Triangles F (m,3) of V (n,3); further options are pyvista's."""
        style = {"color": SURFACE_COLOR, "smooth_shading": False, "ambient": 0.45, "diffuse": 0.7} | style
        if len(F):
            self.plotter.add_mesh(polydata(V, faces=F), **style)

    def lines(self, V: Floats, edges: Ints, *, color: str, width: float, tubes: bool = False) -> None:
        """Segments edges (k,2) of V (n,3); width in pixels, or in thousandths of the diagonal for tubes."""
        if not len(edges):
            return
        mesh = polydata(V, lines=edges)
        if tubes:
            mesh = mesh.tube(radius=width * 1e-3 * self.diagonal, n_sides=12)
            self.plotter.add_mesh(mesh, color=color, smooth_shading=True, ambient=0.25)
        else:
            self.plotter.add_mesh(mesh, color=color, line_width=width)

    def silhouette(self, V: Floats, F: Ints) -> None:
        """The outline of a surface as the camera sees it."""
        self.plotter.add_silhouette(polydata(V, faces=F), color=FEATURE_COLOR, line_width=2.5)

    def label(self, color: str, text: str) -> None:
        """One line of the legend."""
        self._legend.append((text, color))

    def save(self, path: Path) -> None:
        """Draws the scene as PNG and ends it."""
        image = self.plotter.screenshot(None, return_img=True)
        self.plotter.close()
        write_png(path, image, self._legend)


def polydata(V: Floats, *, faces: Ints | None = None, lines: Ints | None = None) -> Any:
    """A pyvista.PolyData of triangles (m,3) or segments (k,2)."""
    import pyvista

    cells = {"faces": faces} if lines is None else {"lines": lines}
    packed = {
        name: np.insert(table, 0, table.shape[1], axis=1).ravel()
        for name, table in cells.items()
        if table is not None
    }
    return pyvista.PolyData(np.asarray(V, np.float64), **packed)


def _light(plotter: Any) -> None:
    """A lamp at the eye and one from above left, both moving with the camera."""
    import pyvista

    plotter.add_light(pyvista.Light(light_type="headlight", intensity=0.5))
    plotter.add_light(pyvista.Light(light_type="camera light", position=(-1.0, 1.4, 0.8), intensity=0.6))


def _aim(camera: Any, points: Floats) -> Floats:
    """Parallel view from above with z up, the longer horizontal side across; returns the direction to the viewer."""
    low, high = points.min(axis=0), points.max(axis=0)
    wide_x = high[0] - low[0] >= high[1] - low[1]
    toward = np.array([0.5, -0.85, 0.55] if wide_x else [0.85, 0.5, 0.55])
    toward /= np.linalg.norm(toward)
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    up = np.cross(toward, right)
    across, upward = points @ right, points @ up
    focus = (
        right * (across.max() + across.min()) / 2
        + up * (upward.max() + upward.min()) / 2
        + toward * float(((low + high) / 2) @ toward)
    )
    distance = float(np.linalg.norm(high - low))
    camera.focal_point, camera.position, camera.up = focus, focus + 2 * distance * toward, up
    camera.parallel_projection = True
    camera.parallel_scale = 0.5 * _MARGIN * max(np.ptp(upward), np.ptp(across) * SIZE[1] / SIZE[0])
    camera.clipping_range = (0.5 * distance, 3.5 * distance)
    return np.asarray(toward)


def spread_sample(points: Floats, cells: int) -> Ints:
    """Indices of points (n,3), at most one for each cube of bounding-box side / cells: the one nearest its centre."""
    low = points.min(axis=0)
    side = max(float(np.ptp(points, axis=0).max()), 1e-300) / cells
    cell = np.minimum(np.floor((points - low) / side), cells - 1)
    off_centre = np.linalg.norm((points - low) / side - cell - 0.5, axis=1)
    keys = cell @ np.array([1.0, cells, cells**2])
    order = np.lexsort([off_centre, keys])
    first = np.concatenate([[True], np.diff(keys[order]) > 0])
    return np.sort(order[first])
