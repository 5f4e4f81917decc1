"""Scenes of surfaces, tubes and arrows, drawn offscreen to plain images.

Nothing is written into the images: text is laid over them on the page, at the pixels that
`Picture.project` gives. Lengths are mm.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray: TypeAlias = NDArray[np.float64]

Size: TypeAlias = tuple[int, int]
"""Width and height in pixels."""

Pose: TypeAlias = tuple[FloatArray, FloatArray]
"""Rotation (3, 3) and shift (3,), mm: a point x of an item is drawn at rotation @ x + shift."""

MESH_PX = 0.2
"""Pixels by which triangles of gears may miss their surfaces: finer is not seen (`test_picture_density`)."""
JOINED = 1e-6
"""mm within which ends of lines are one."""
EDGE_ANGLE_DEG = 35.0
EDGE_COLOUR = "#303840"
# Lights in the camera's frame (right, up, towards the viewer), and their strengths.
LIGHTS = (((-1.0, 0.75, 0.6), 0.62), ((-0.42, 0.12, 1.0), 0.4), ((0.9, -0.3, 0.7), 0.16))
METAL: dict[str, Any] = {"ambient": 0.26, "diffuse": 0.84, "specular": 0.45, "specular_power": 45.0}
DULL: dict[str, Any] = {"ambient": 0.78, "diffuse": 0.3, "specular": 0.0}
UNLIT: dict[str, Any] = {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0}
PLAIN: dict[str, Any] = {"ambient": 0.55, "diffuse": 0.55, "specular": 0.1, "specular_power": 10.0}


@dataclass(frozen=True, eq=False)
class Paint:
    """Values (n,) at the points of a surface, shown in bands of equal steps: one of `colours`
    each, from the lower to the upper of `limits`, and those beyond as at the limit. Where a
    value is NaN the surface keeps its own colour. Neither is lit: a band is drawn in just the colour that
    its legend has."""

    values: FloatArray
    colours: Sequence[str]
    limits: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Surface:
    """Faces of three or four corners over points (n, 3), lit as metal.

    `normals` (n, 3) give smooth shading; without them faces are flat. `edges` draws
    boundaries and sharp edges as dark lines, `mesh_lines` the edges of all faces, without lustre. At an
    opacity of 0 nothing but lines is drawn."""

    points: FloatArray
    faces: NDArray[np.integer[Any]]
    normals: FloatArray | None = None
    colour: str = "#b9c4cf"
    opacity: float = 1.0
    edges: bool = False
    paint: Paint | None = None
    mesh_lines: bool = False


@dataclass(frozen=True, eq=False)
class Tube:
    """A round tube along a polyline (n, 3); one point gives a ball."""

    points: FloatArray
    colour: str
    radius: float


@dataclass(frozen=True, eq=False)
class Arrow:
    """A straight arrow from `start` by `vector`, both (3,); `radius` is that of the shaft."""

    start: FloatArray
    vector: FloatArray
    colour: str
    radius: float


Item: TypeAlias = Surface | Tube | Arrow


@dataclass(frozen=True, eq=False)
class Camera:
    """Parallel projection: looking along `direction`, `up` upwards, `focal_point` (3,) in the
    middle, and `half_height` mm from there to the upper edge of the picture."""

    direction: FloatArray
    up: FloatArray
    focal_point: FloatArray
    half_height: float

    @property
    def axes(self) -> FloatArray:
        """Unit vectors right, up, and towards the viewer, rows of (3, 3)."""
        back = -np.asarray(self.direction, dtype=float)
        back = back / np.linalg.norm(back)
        right = np.cross(self.up, back)
        right = right / np.linalg.norm(right)
        return np.stack((right, np.cross(back, right), back))

    def mm_per_px(self, size_px: Size) -> float:
        """Give mm in the plane of a picture of this size for each of its pixels."""
        return float(2.0 * self.half_height / size_px[1])


@dataclass(frozen=True, eq=False)
class Scene:
    """What is seen, and from where."""

    items: Sequence[Item]
    camera: Camera


@dataclass(frozen=True, eq=False)
class Picture:
    """A drawn scene: `image` (height, width, 3) of 8 bit, and the number of its triangles."""

    image: NDArray[np.uint8]
    camera: Camera
    triangles: int

    @property
    def px_per_mm(self) -> float:
        """Pixels per mm in the plane of the picture."""
        return float(self.image.shape[0] / (2.0 * self.camera.half_height))

    def project(self, points: ArrayLike) -> FloatArray:
        """Give pixels (..., 2) of points (..., 3): x to the right and y down from the top left."""
        height, width = self.image.shape[:2]
        offset = (np.asarray(points, dtype=float) - self.camera.focal_point) @ self.camera.axes.T
        centre = np.array([width, height]) / 2.0
        return np.asarray(centre + self.px_per_mm * offset[..., :2] * (1.0, -1.0))


def fit_camera(
    points: ArrayLike, direction: ArrayLike, up: ArrayLike, size_px: Size, margin: float = 0.05
) -> Camera:
    """Find the camera that shows all points in a picture of this size, with a margin on each side as a share
    of it."""
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    direction, up = np.asarray(direction, dtype=float), np.asarray(up, dtype=float)
    axes = Camera(direction, up, np.zeros(3), 1.0).axes
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    half = (high - low) / (2.0 * (1.0 - 2.0 * margin))
    half_height = max(half[1], half[0] * size_px[1] / size_px[0], 1e-9)
    return Camera(direction, axes[1], (low + high) / 2.0 @ axes, float(half_height))


def render(scene: Scene, size_px: Size) -> Picture:
    """Draw a scene offscreen on white."""
    with _window(scene, size_px) as (plotter, _, triangles):
        return Picture(_shot(plotter), scene.camera, triangles)


def render_moving(scene: Scene, size_px: Size, poses: Iterable[Sequence[Pose]]) -> Iterator[Picture]:
    """Draw a scene once for every one of `poses`, which holds a pose for each item; the window stays open
    between, and pixels are smoothed by few samples (MSAA), which saves most of the time."""
    import pyvista as pv

    with _window(scene, size_px, "msaa") as (plotter, actors, triangles):
        for pose in poses:
            for (rotation, shift), parts in zip(pose, actors, strict=True):
                matrix = np.eye(4)
                matrix[:3, :3], matrix[:3, 3] = rotation, shift
                for actor in parts:
                    actor.SetUserMatrix(pv.vtkmatrix_from_array(matrix))
            plotter.renderer.ResetCameraClippingRange()
            yield Picture(_shot(plotter), scene.camera, triangles)


@contextmanager
def _window(
    scene: Scene, size_px: Size, smoothing: str = "ssaa"
) -> Iterator[tuple[Any, list[list[Any]], int]]:
    """Open an offscreen window with a scene, the actors of each item, and the number of triangles."""
    import pyvista as pv  # half a second, and only wanted here

    plotter: Any = pv.Plotter(off_screen=True, window_size=list(size_px), lighting="none")
    try:
        plotter.set_background("white")
        triangles, actors = 0, []
        for item in scene.items:
            before = len(plotter.actors)
            triangles += _add(plotter, item)
            actors.append(list(plotter.actors.values())[before:])
        _aim(plotter, scene.camera)
        plotter.enable_anti_aliasing(smoothing)
        yield plotter, actors, triangles
    finally:
        plotter.close()


def _shot(plotter: Any) -> NDArray[np.uint8]:
    plotter.render()
    return np.array(plotter.screenshot(return_img=True)[..., :3])


def _aim(plotter: Any, camera: Camera) -> None:
    """Set lights and camera."""
    import pyvista as pv

    right, up, back = camera.axes
    for place, strength in LIGHTS:
        towards = np.asarray(place) @ np.stack((right, up, back))
        light = pv.Light(position=camera.focal_point + 1e5 * towards, focal_point=camera.focal_point)
        light.positional = False
        light.intensity = strength
        plotter.add_light(light)
    plotter.camera.parallel_projection = True
    plotter.camera.focal_point = camera.focal_point
    plotter.camera.position = camera.focal_point + 20.0 * camera.half_height * back
    plotter.camera.up = up
    plotter.camera.parallel_scale = camera.half_height
    plotter.renderer.ResetCameraClippingRange()


def _add(plotter: Any, item: Item) -> int:
    """Add one item; the number of its triangles."""
    if isinstance(item, Surface):
        return _add_surface(plotter, item)
    mesh = _tube(item) if isinstance(item, Tube) else _arrow(item)
    plotter.add_mesh(mesh, color=item.colour, smooth_shading=True, split_sharp_edges=True, **PLAIN)
    return int(mesh.triangulate().n_cells)


def _add_surface(plotter: Any, surface: Surface) -> int:
    """Add a surface with its edges; the number of its triangles."""
    import pyvista as pv

    faces: Any = surface.faces
    mesh = pv.PolyData.from_regular_faces(surface.points, faces)
    smooth = surface.normals is not None
    if smooth:
        mesh.point_data.active_normals = np.asarray(surface.normals)
    look = {"color": surface.colour} if surface.paint is None else _bands(surface.paint, surface.colour)
    lustre = UNLIT if surface.paint is not None else DULL if surface.mesh_lines else METAL
    look |= {"opacity": surface.opacity, "smooth_shading": smooth, **lustre}
    look |= {"show_edges": surface.mesh_lines, "edge_color": EDGE_COLOUR, "line_width": 1.0}
    actor = plotter.add_mesh(mesh, **look)
    actor.SetVisibility(surface.opacity > 0.0)
    if surface.edges:
        lines = mesh.extract_feature_edges(EDGE_ANGLE_DEG, manifold_edges=False, non_manifold_edges=False)
        if lines.n_cells:
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()  # the lines stand before the faces
            actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 2.0)
            plotter.add_mesh(lines, color=EDGE_COLOUR, line_width=1.5, lighting=False)
    return int(len(faces) * (faces.shape[1] - 2))


def cut(surface: Surface, point: FloatArray, normal: FloatArray) -> list[FloatArray]:
    """Cut a closed surface by a plane through `point` (3,): its outlines (n, 3), each in order and closed."""
    import pyvista as pv

    faces = np.column_stack((np.full(len(surface.faces), surface.faces.shape[1]), surface.faces))
    lines: Any = pv.PolyData(surface.points, faces.ravel()).slice(normal=normal, origin=point)
    lines = lines.clean(tolerance=JOINED, absolute=True).strip(join=True, max_length=lines.n_cells)
    return [np.asarray(lines.get_cell(k).points) for k in range(lines.n_cells)]


def _bands(paint: Paint, nothing: str) -> dict[str, Any]:
    """Say what pyvista takes to show values as bands with sharp edges."""
    return {
        "scalars": np.asarray(paint.values, dtype=float),
        "cmap": list(paint.colours),
        "n_colors": len(paint.colours),
        "clim": paint.limits,
        "nan_color": nothing,
        "interpolate_before_map": True,
        "show_scalar_bar": False,
    }


def _tube(tube: Tube) -> Any:
    import pyvista as pv

    points = np.atleast_2d(np.asarray(tube.points, dtype=float))
    if len(points) == 1:
        return pv.Sphere(radius=tube.radius, center=points[0], theta_resolution=24, phi_resolution=24)
    return pv.lines_from_points(points).tube(radius=tube.radius, n_sides=16, capping=True)


def _arrow(arrow: Arrow) -> Any:
    import pyvista as pv

    length = float(np.linalg.norm(arrow.vector))
    tip = min(7.0 * arrow.radius, 0.6 * length)
    thin, thick = arrow.radius / length, 2.6 * arrow.radius / length
    place: dict[str, Any] = {"start": arrow.start, "direction": arrow.vector, "scale": length}
    shape: dict[str, Any] = {"shaft_radius": thin, "tip_radius": thick, "tip_length": tip / length}
    return pv.Arrow(**place, **shape, shaft_resolution=24, tip_resolution=24)


def grid_surface(
    points: FloatArray, normals: FloatArray | None, colour: str, opacity: float = 1.0, edges: bool = False
) -> Surface:
    """Make a surface from a grid of points (rows, columns, 3), with its normals if there are any: its faces
    then look the same way."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    corners = (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    faces = np.stack([corner.ravel() for corner in corners], axis=1)
    flat, lit = points.reshape(-1, 3), None if normals is None else normals.reshape(-1, 3)
    if lit is not None:
        a, b, c, d = flat[faces.T]
        facing = np.einsum("ni,ni->", np.cross(c - a, d - b), lit[faces[:, 0]])
        faces = faces if facing >= 0.0 else faces[:, ::-1]
    return Surface(flat, faces, lit, colour, opacity, edges)
