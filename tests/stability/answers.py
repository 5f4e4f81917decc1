"""Checks of every result: the five equations hold, or the values are NaN with a named status."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import radians
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import ArrayLike

from beveloid_geom import ContactPath, Design, Member, Pair, Status, path_of_contact, zero_backlash_layout
from beveloid_geom.arrays import Flank
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.shapes.proximity.mesh_contact import mesh_contact
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.shapes.test_mesh_contact import pose_at

from .five_residuals import batch_of_one, cases_of, residuals

FLANKS = ("right", "left")
NUMBERS = (
    *("u1", "l2", "u2", "pinion_roll", "gear_roll"),
    *("pinion_z", "pinion_r", "gear_z", "gear_r"),
)
SIZE = 500.0
"""mm: about the size of the pair of Table 1, offset and both radii; bounds shrink with smaller pairs."""


def changed(member: Member, **values: Any) -> Member:
    """Return the member with other quantities, including those of its tool."""
    tool = {name: values.pop(name) for name in tuple(values) if hasattr(member.tool, name)}
    return replace(member, tool=replace(member.tool, **tool), **values)


def closed(pinion: Member, gear: Member) -> Design:
    """Return the pair with the layout without backlash."""
    found = zero_backlash_layout(Design(pinion, gear, Pair(1.0, 1.0)))
    return Design(pinion, gear, Pair(float(found.offset), float(found.shaft_angle)))


def held(design: Design) -> Design:
    """Return the design with its present mounting distances fixed."""
    first, second = mounting_of(design).distance
    pair = replace(design.pair, pinion_mounting=float(first), gear_mounting=float(second))
    return replace(design, pair=pair)


def at_shaft_angle(design: Design, degrees: float) -> Design:
    return replace(design, pair=replace(design.pair, shaft_angle=radians(degrees)))


def size_of(design: Design) -> float:
    return float(design.pair.offset + sum(reference_radius(member) for member in design.members))


def check(design: Design, path: ContactPath) -> None:
    """Check that every position satisfies the five equations, or is NaN with a status."""
    assert set(np.unique(path.status)) <= {int(status) for status in Status}
    values = np.stack([getattr(path, name) for name in NUMBERS])
    values = np.concatenate((values, np.moveaxis(path.point, -1, 0), np.moveaxis(path.normal, -1, 0)))
    known = np.isfinite(values).all(axis=0)
    assert (known | np.isnan(values).all(axis=0)).all()
    named = (path.status == Status.SOLVED) | (path.status == Status.OFF_FLANK)
    assert not (known & ~named).any()
    assert known[path.status == Status.SOLVED].all()
    # Without a path on the flanks the transmission error may lack a position to refer to.
    referred = np.broadcast_to((path.ends.status == Status.SOLVED)[..., None], known.shape)
    np.testing.assert_array_equal(np.isfinite(path.transmission_error)[referred], known[referred])
    if known.any():
        apart, turned = residuals(design, path, mounting_of(design).distance)
        bound = 1e-9 * min(1.0, size_of(design) / SIZE)
        assert np.nanmax(apart[known]) < bound
        assert np.nanmax(turned[known]) < 1e-12


def checked_path(design: Design, flank: str = "right", points: int = 21) -> ContactPath:
    """Return the path of contact after checking it, and contacts at flank parameters on and off the flank."""
    path = path_of_contact(design, flank, points)
    check(design, path)
    module = float(design.pinion.tool.normal_module)
    l1: ArrayLike = np.linspace(-1.6, 1.6, 17) * module
    check(design, path_of_contact(design, flank, l1=l1))
    return path


@contextmanager
def without_undercut() -> Iterator[None]:
    """Ignore undercut in paths of batches of members, as oracles of the generated flanks do."""
    with patch("beveloid_geom.contact.flank_pair.undercut_edge", return_value=None):
        yield


def path_without_undercut(design: Design, flank: Flank, points: int) -> ContactPath:
    """Return the path of a single design on flanks that undercut does not end."""
    with without_undercut():
        path: ContactPath = cases_of(path_of_contact(batch_of_one(design), flank, points), 0)
    return path


def assert_no_path(design: Design, flank: str, status: Status) -> None:
    """Check that there is no position, that the status gives the reason, and that the contact ratio is 0, or
    NaN if nothing is defined."""
    path = checked_path(design, flank)
    assert path.l1.size == 0
    assert path.ends.status == status
    assert path.ends.enter is None
    np.testing.assert_equal(float(path.ends.contact_ratio), np.nan if status == Status.UNDEFINED else 0.0)


def solved_path(design: Design, flank: str = "right", points: int = 21) -> ContactPath:
    """Return the checked path of contact of a pair that has one."""
    path = checked_path(design, flank, points)
    assert path.ends.status == Status.SOLVED
    assert (path.status == Status.SOLVED).all()
    assert len(path.l1) == points
    assert path.ends.contact_ratio > 0.0
    return path


def assert_five_equations_agree(path: ContactPath, bound: float | None = None) -> None:
    """Check that the five equations give the same points, within the bound (mm), and contact ratio."""
    other = path_of_contact_five_equations(path.design, path.flank, len(path.l1))
    bound = bound or 1e-9 * max(1.0, size_of(path.design) / SIZE)
    np.testing.assert_allclose(path.point, other.point, rtol=0.0, atol=bound)
    assert abs(float(other.ends.contact_ratio - path.ends.contact_ratio)) < 1e-9


def assert_every_method_agrees(
    path: ContactPath, of_five: float | None = None, of_meshes: float | None = None
) -> None:
    """Check that the five equations and the polished meshes give the same contact as the path;
    bounds in mm."""
    assert_five_equations_agree(path, of_five)
    middle, tolerance = len(path.l1) // 2, 1e-3 * float(path.design.pinion.tool.normal_module)
    met = mesh_contact(path.design, path.flank, tolerance, **pose_at(path, middle))
    assert met.status == Status.SOLVED
    assert np.abs(met.point - path.point[middle]).max() < (of_meshes or 1e-9 * size_of(path.design))
