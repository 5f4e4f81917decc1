"""Distance of triangles from the surface they approximate, independent of the code that made them."""

from __future__ import annotations

import numpy as np

from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.sampling import FlankGrid
from beveloid_geom.shapes.sheet import Sheet, SheetGrid, grid_faces


def inside_triangles(
    grid: SheetGrid | FlankGrid, parameter: FloatArray, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points (n, 3) in all triangles of a grid, on edges and inside, with their parameters."""
    faces = grid_faces(grid.points, grid.normals)
    weights = np.random.default_rng(1).dirichlet((1.0, 1.0, 1.0), count)
    weights = np.concatenate((weights, [[0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]]))
    z = np.broadcast_to(grid.z, parameter.shape)
    p, z = ((weights @ values.ravel()[faces].T).T.ravel() for values in (parameter, z))
    points = np.einsum("kc,mci->mki", weights, grid.points.reshape(-1, 3)[faces])
    return points.reshape(-1, 3), p, z


def distance_bound(sheet: Sheet, points: FloatArray, p: FloatArray, z: FloatArray) -> FloatArray:
    """Return an upper bound of the distance (n,) of points from a surface, by damped Newton steps from
    parameters nearby."""
    span = sheet.upper(z) - sheet.lower(z)
    best = np.full(len(points), np.inf)
    for _ in range(25):
        here, _ = sheet.place(p, z)
        away = points - here
        best = np.minimum(best, np.linalg.norm(away, axis=-1))
        steps = (1e-5 * span, 0.0 * z), (0.0 * p, np.full_like(z, 1e-5))
        tangents = [sheet.place(p + dp, z + dz)[0] - sheet.place(p - dp, z - dz)[0] for dp, dz in steps]
        tangent = np.stack(tangents, axis=-1) / 2e-5
        metric = np.einsum("nia,nib->nab", tangent, tangent)
        metric += 1e-3 * np.eye(2) * np.trace(metric, axis1=1, axis2=2)[:, None, None]
        move = np.linalg.solve(metric, np.einsum("nia,ni->na", tangent, away)[..., None])[..., 0]
        p, z = p + move[:, 0] * span, z + move[:, 1]
    return best
