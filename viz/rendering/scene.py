"""Draw scenes of surfaces, tubes and arrows off screen to images.

Images contain no text. Text is placed over them on the page, at the pixels that `Picture.project` returns.
Lengths are mm.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .camera import VIEW_ANGLE_DEG, Camera as Camera, Size as Size, fit_camera as fit_camera
from .polylines import FloatArray, simplified

MESH_PX = 0.2
"""Largest deviation of the triangles of gears from the surface, pixels; smaller values make no visible
difference (`test_picture_density`)."""
TUBE_SIDES = 8
"""Sides of tubes and shafts of arrows."""
ROUND_SIDES = 16
"""Sides of balls and arrow heads."""
JOINED_MM = 1e-6
"""Largest distance of points that are joined."""


@dataclass(frozen=True, eq=False)
class Paint:
    """Values at the points of a surface, shown as bands of equal steps. Bands are not lit, so that each has
    the colour of its entry in the legend.

    Attributes
    ----------
    values : ndarray, shape (n,)
        Values; where a value is NaN, the colour of the surface is shown.
    colours : sequence of str
        Colour of each band, from the lower to the upper limit.
    limits : tuple of float
        Lower and upper limit. Values outside have the colour of the nearest limit.
    """

    values: FloatArray
    colours: Sequence[str]
    limits: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Surface:
    """Surface of triangles or quadrilaterals, lit as metal.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Points, mm.
    faces : ndarray of int, shape (m, 3) or (m, 4)
        Indices of the corners.
    normals : ndarray, shape (n, 3), optional
        Unit normals for smooth shading. Without them, faces are shaded flat.
    colour : str
        Colour.
    opacity : float
        Opacity; with 0, only lines are drawn.
    edges : bool
        True to draw boundaries and sharp edges as dark lines.
    paint : Paint, optional
        Values shown as colours.
    mesh_lines : bool
        True to draw the edges of all faces, without highlights.
    """

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
    """Round tube along a polyline (n, 3), mm; a single point is drawn as a ball."""

    points: FloatArray
    colour: str
    radius: float


@dataclass(frozen=True, eq=False)
class Arrow:
    """Straight arrow from `start` (3,) along `vector` (3,), mm; `radius` is the radius of the shaft."""

    start: FloatArray
    vector: FloatArray
    colour: str
    radius: float


Item: TypeAlias = Surface | Tube | Arrow


@dataclass(frozen=True, eq=False)
class Scene:
    """Items and the camera that looks at them."""

    items: Sequence[Item]
    camera: Camera


@dataclass(frozen=True, eq=False)
class Picture:
    """Rendered scene: image (height, width, 3) of 8 bits per channel, camera, and number of triangles."""

    image: NDArray[np.uint8]
    camera: Camera
    triangles: int

    @property
    def px_per_mm(self) -> float:
        """Pixels per mm in the plane through the focal point."""
        return float(self.image.shape[0] / (2.0 * self.camera.half_height))

    def project(self, points: ArrayLike) -> FloatArray:
        """Return the pixels (..., 2) of points (..., 3), mm. The origin is the upper left corner; y points
        down."""
        height, width = self.image.shape[:2]
        centre = np.array([width, height]) / 2.0
        return np.asarray(centre + self.px_per_mm * self.camera.seen(points) * (1.0, -1.0))


def render(scene: Scene, size_px: Size) -> Picture:
    """Draw a scene off screen on a white background.

    Parameters
    ----------
    scene : Scene
        Items and camera.
    size_px : tuple of int
        Width and height, pixels.

    Returns
    -------
    Picture
        Image, camera and number of triangles.
    """
    import pyvista as pv  # takes half a second to import

    plotter: Any = pv.Plotter(off_screen=True, window_size=list(size_px), lighting="none")
    # Ambient occlusion, as fractions of half the picture height: radius within which neighbouring points
    # darken a point, and bias. Neighbours nearer to the viewer by less than the bias do not darken it. The
    # depths of VTK have about 11 bits: a smaller bias or a more distant camera gives stripes.
    occlusion_radius, occlusion_bias = 0.09, 0.01
    try:
        plotter.set_background("white")
        triangles = add_items(plotter, scene.items)
        aim(plotter, scene.camera)
        plotter.enable_anti_aliasing("ssaa")
        if scene.camera.perspective:
            reach, bias = (k * scene.camera.half_height for k in (occlusion_radius, occlusion_bias))
            plotter.enable_ssao(radius=reach, bias=bias, kernel_size=32)
        plotter.render()
        image = np.array(plotter.screenshot(return_img=True)[..., :3])
        return Picture(image, scene.camera, triangles)
    finally:
        plotter.close()


def aim(plotter: Any, camera: Camera) -> None:
    """Set lights and camera of the active view. The lights move with the camera."""
    # Lights: direction in the frame of the camera (right, up, towards the viewer), and intensity.
    lights = (((-1.0, 0.75, 0.6), 0.62), ((-0.42, 0.12, 1.0), 0.4), ((0.9, -0.3, 0.7), 0.16))
    import pyvista as pv

    _, up, back = camera.axes
    for place, strength in lights:
        towards = np.asarray(place) @ camera.axes
        light = pv.Light(position=camera.focal_point + 1e5 * towards, focal_point=camera.focal_point)
        light.positional = False
        light.intensity = strength
        plotter.add_light(light, only_active=True)
    plotter.camera.parallel_projection = not camera.perspective
    plotter.camera.view_angle = VIEW_ANGLE_DEG
    plotter.camera.focal_point = camera.focal_point
    plotter.camera.position = camera.focal_point + camera.distance * back
    plotter.camera.up = up
    plotter.camera.parallel_scale = camera.half_height
    plotter.renderer.ResetCameraClippingRange()


def add_items(plotter: Any, items: Sequence[Item]) -> int:
    """Add items to the active view, lines and arrows of a colour as one actor; return their number of
    triangles."""
    tubes: dict[tuple[str, float], list[FloatArray]] = {}
    meshes: dict[str, list[Any]] = {}
    for item in items:
        if isinstance(item, Tube):
            tubes.setdefault((item.colour, item.radius), []).append(np.atleast_2d(item.points))
        elif isinstance(item, Arrow):
            meshes.setdefault(item.colour, []).append(_arrow(item))
    for (colour, radius), lines in tubes.items():
        meshes.setdefault(colour, []).extend(tube_meshes(lines, radius))
    surfaces = sum(_add_surface(plotter, item) for item in items if isinstance(item, Surface))
    return surfaces + sum(_add_lines(plotter, parts, colour) for colour, parts in meshes.items())


def _add_lines(plotter: Any, meshes: list[Any], colour: str) -> int:
    """Add tubes, balls and arrows as one actor; return their number of triangles."""
    plain = {"ambient": 0.55, "diffuse": 0.55, "specular": 0.1, "specular_power": 10.0}
    import pyvista as pv

    mesh = pv.merge([mesh.triangulate() for mesh in meshes], merge_points=False)
    # Faces at smaller angles than the feature angle, degrees, are shaded as one smooth surface.
    smooth = {"smooth_shading": True, "split_sharp_edges": True, "feature_angle": 60.0}
    plotter.add_mesh(mesh, name=_unused_name(plotter), color=colour, **smooth, **plain)
    return int(mesh.n_cells)


def _unused_name(plotter: Any) -> str:
    """Return a name for the next actor.

    PyVista replaces an actor of the same name. Its own names are memory addresses; version 0.45 uses some of
    them twice, so that items disappear."""
    return f"item {sum(len(renderer.actors) for renderer in plotter.renderers)}"


def _add_surface(plotter: Any, surface: Surface) -> int:
    """Add a surface with its edges; return its number of triangles."""
    edge_angle_deg = 35.0
    edge_colour = "#303840"
    metal: dict[str, Any] = {"ambient": 0.26, "diffuse": 0.84, "specular": 0.45, "specular_power": 45.0}
    dull: dict[str, Any] = {"ambient": 0.78, "diffuse": 0.3, "specular": 0.0}
    unlit: dict[str, Any] = {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0}
    import pyvista as pv

    faces: Any = surface.faces
    mesh = pv.PolyData.from_regular_faces(surface.points, faces)
    smooth = surface.normals is not None
    if smooth:
        mesh.point_data.active_normals = np.asarray(surface.normals)
    look = {"color": surface.colour} if surface.paint is None else _bands(surface.paint, surface.colour)
    lustre = unlit if surface.paint is not None else dull if surface.mesh_lines else metal
    look |= {"opacity": surface.opacity, "smooth_shading": smooth, **lustre}
    look |= {"show_edges": surface.mesh_lines, "edge_color": edge_colour, "line_width": 1.0}
    actor = plotter.add_mesh(mesh, name=_unused_name(plotter), **look)
    actor.SetVisibility(surface.opacity > 0.0)
    if surface.edges:
        joined = mesh.clean(tolerance=JOINED_MM, absolute=True)  # points with two normals are given twice
        lines = joined.extract_feature_edges(edge_angle_deg, manifold_edges=False, non_manifold_edges=False)
        if lines.n_cells:
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()  # edges in front of their faces
            actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 2.0)
            name = _unused_name(plotter)
            plotter.add_mesh(lines, name=name, color=edge_colour, line_width=1.5, lighting=False)
    return int(len(faces) * (faces.shape[1] - 2))


def cut(surface: Surface, point: FloatArray, normal: FloatArray) -> list[FloatArray]:
    """Intersect a closed surface with a plane through `point` (3,). Returns closed outlines (n, 3), mm."""
    import pyvista as pv

    faces: Any = surface.faces
    lines: Any = pv.PolyData.from_regular_faces(surface.points, faces).slice(normal=normal, origin=point)
    lines = lines.clean(tolerance=JOINED_MM, absolute=True).strip(join=True, max_length=lines.n_cells)
    return [np.asarray(lines.get_cell(k).points) for k in range(lines.n_cells)]


def divided(surface: Surface, level: FloatArray) -> tuple[Surface, Surface]:
    """Divide a surface of triangles where the values `level` (n,) at its points are zero.

    Returns the parts with positive and negative values."""
    import pyvista as pv

    faces: Any = surface.faces
    mesh: Any = pv.PolyData.from_regular_faces(surface.points, faces)
    mesh.point_data["level"] = level
    if surface.paint is not None:
        mesh.point_data["values"] = surface.paint.values

    def side(below: bool) -> Surface:
        """Return the part with negative values (`below`), or that with positive values."""
        part = mesh.clip_scalar(scalars="level", value=0.0, invert=below).triangulate()
        paint = surface.paint and replace(surface.paint, values=np.asarray(part["values"]))
        points, faces = np.asarray(part.points), part.regular_faces
        return replace(surface, points=points, faces=faces, normals=None, paint=paint)

    return side(False), side(True)


def _bands(paint: Paint, nothing: str) -> dict[str, Any]:
    """Return the arguments of `add_mesh` that show values as bands with sharp borders."""
    return {
        "scalars": np.asarray(paint.values, dtype=float),
        "cmap": list(paint.colours),
        "n_colors": len(paint.colours),
        "clim": paint.limits,
        "nan_color": nothing,
        "interpolate_before_map": True,
        "show_scalar_bar": False,
    }


def tube_meshes(lines: Sequence[FloatArray], radius: float) -> Iterator[Any]:
    """Yield the meshes of tubes along lines (n, 3), and of balls at single points."""
    import pyvista as pv

    for ball in (line[0] for line in lines if len(line) == 1):
        sides: dict[str, Any] = {"theta_resolution": ROUND_SIDES, "phi_resolution": ROUND_SIDES // 2 + 1}
        yield pv.Sphere(radius=radius, center=ball, **sides)
    # Tubes deviate from their lines by less than 0.3 pixels in the paths of figures.
    if long := [simplified(line, 0.05 * radius) for line in lines if len(line) > 1]:
        cells = np.split(np.arange(sum(map(len, long))), np.cumsum([len(line) for line in long])[:-1])
        index = np.concatenate([np.r_[len(cell), cell] for cell in cells])
        centres = pv.PolyData(np.concatenate(long), lines=index)
        yield centres.tube(radius=radius, n_sides=TUBE_SIDES, capping=True)


def _arrow(arrow: Arrow) -> Any:
    import pyvista as pv

    length = float(np.linalg.norm(arrow.vector))
    tip = min(7.0 * arrow.radius, 0.6 * length)
    thin, thick = arrow.radius / length, 2.6 * arrow.radius / length
    place: dict[str, Any] = {"start": arrow.start, "direction": arrow.vector, "scale": length}
    shape: dict[str, Any] = {"shaft_radius": thin, "tip_radius": thick, "tip_length": tip / length}
    return pv.Arrow(**place, **shape, shaft_resolution=TUBE_SIDES, tip_resolution=ROUND_SIDES)


def grid_surface(
    points: FloatArray, normals: FloatArray | None, colour: str, opacity: float = 1.0, edges: bool = False
) -> Surface:
    """Return a surface of quadrilaterals over a grid of points.

    Parameters
    ----------
    points : ndarray, shape (rows, columns, 3)
        Points, mm.
    normals : ndarray, shape (rows, columns, 3) or None
        Unit normals; the faces are oriented to agree with them.
    colour : str
        Colour.
    opacity : float
        Opacity.
    edges : bool
        True to draw the boundary.

    Returns
    -------
    Surface
        Surface of the grid.
    """
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
