"""The situations of the table: designs and flanks, small and explicit; most are used by other tests as
well."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from math import radians
from unittest.mock import patch

import numpy as np

from beveloid_geom import Design, Errors, Member, MeshErrors, builtin_design, path_of_contact
from beveloid_geom.contact.mesh_position import Frame, frames_at
from beveloid_geom.contact.path import path_ends
from beveloid_geom.design.file import DesignError, builtin_text, parse_design
from beveloid_geom.pair.misalignment_at_mesh import from_mesh
from beveloid_geom.shapes.proximity import mesh_separation as proximity
from beveloid_geom.shapes.proximity.flank_mesh import FlankMesh, flank_mesh
from tests.contact.test_path_search import TURNING
from tests.oracle.table1 import table1
from tests.symmetry import exchanged, mirrored, scaled
from tests.validation import test_intersecting_axes as intersecting

from . import test_line_contact as line_contact, test_meshes as meshes
from .answers import at_shaft_angle, changed, closed, held
from .named_designs import CROSSING, LOST, SPLIT
from .outcomes import Case, Said, Situation, all_notes, checked
from .parallel_pairs import HELICAL
from .test_cones_and_helices import PLAIN, with_cones
from .test_shaft_angles import fold, folding, right_angled
from .test_shapes_of_teeth import APART, MANY, ONE, POINTED, UNDERCUT, of_module

PINION, GEAR = table1().members
PATHS = ("one equation", "five equations")
ALL = (*PATHS, "polished")
STATUS = ("status",)
LINES = builtin_design("anti-backlash")
CONVEX = LINES.with_parabola(-0.004, -0.004)
FAR = (1e4, -1e4, 1e4)
"""mm"""


def of(*designs: Design, flanks: Sequence[str] = ("right",)) -> Callable[[], list[Case]]:
    return lambda: [Case(design, flank) for design in designs for flank in flanks]


def late(*designs: Callable[[], Design], flank: str = "right") -> Callable[[], list[Case]]:
    """Designs that take some time; they are built when they are run."""
    return lambda: [Case(design(), flank) for design in designs]


def in_file(old: str, new: str) -> Said:
    """Return the message of reading the built-in design file after a replacement."""

    def texts(design: Design, flank: str) -> Iterable[str]:
        assert old in builtin_text()
        try:
            parse_design(builtin_text().replace(old, new))
        except DesignError as refused:
            return refused.faults
        return ()

    return texts


def spur(pinion: float, gear: float) -> Design:
    """Return Table 1 with other helix angles, deg."""
    first, second = (
        changed(m, helix_angle=radians(b)) for m, b in zip((PINION, GEAR), (pinion, gear), strict=True)
    )
    return replace(table1(), pinion=first, gear=second)


def one_spur(degrees: float) -> Design:
    return closed(PINION, changed(GEAR, helix_angle=radians(degrees)))


def nearly_parallel(total: float) -> Design:
    first, second = PLAIN.members
    return held(closed(first, changed(second, helix_angle=radians(total) - float(first.helix_angle))))


def of_hands(pinion: float, gear: float) -> Design:
    first, second = (
        changed(m, helix_angle=radians(b), cone_angle=radians(1.0))
        for m, b in zip((PINION, GEAR), (pinion, gear), strict=True)
    )
    return closed(first, second)


def tilted(design: Design) -> Design:
    return design.with_errors(Errors(shaft_angle=radians(0.01)))


def near_the_fold(*where: float) -> list[Case]:
    """Return poses of the meshes at distances `where` in l1 (mm) from the position at which the roll is
    stationary: positive on the side of positive curvature, negative on the side of the saddle point."""
    cases = []
    for a in line_contact.FOLDS:
        design, middle = line_contact.concave(a), line_contact.fold(a)
        start, stop = path_ends(design).l1
        path = path_of_contact(design, l1=[middle + 0.1])
        up = np.sign(line_contact.smaller_curvature(a, path)[0])
        cases += [Case(design, share=float((middle + up * w - start) / (stop - start))) for w in where]
    return cases


def thin() -> list[Case]:
    return [Case(meshes.narrow(width)[0], "left", tolerance=0.01) for width in (1e-2, 1e-4)]


def single_precision() -> AbstractContextManager[object]:
    def mesh(member: Member, flank: str, tolerance: float) -> FlankMesh:
        exact = flank_mesh(member, flank, tolerance)
        points = exact.grid.points.astype(np.float32).astype(float)
        return replace(exact, grid=replace(exact.grid, points=points))

    return patch.object(proximity, "flank_mesh", mesh)


def ten_metres_away() -> AbstractContextManager[object]:
    def frames(design: Design, pinion: float, gear: float) -> tuple[Frame, Frame]:
        first, second = frames_at(design, pinion, gear)
        return (first[0], first[1] + np.array(FAR)), (second[0], second[1] + np.array(FAR))

    return patch.object(proximity, "frames_at", frames)


def turned(errors: Errors | MeshErrors) -> Design:
    """Return a pair on intersecting axes under errors about the common perpendicular or at the mesh."""
    design = builtin_design("awd-transfer").with_parabola(1e-3, -1e-3)
    return design.with_errors(errors if isinstance(errors, Errors) else from_mesh(design, errors))


def symmetric() -> Iterator[Case]:
    design = closed(*MODIFIED.members)
    yield from (Case(design), Case(mirrored(design), "left"), Case(exchanged(design)))
    yield from (Case(scaled(design, 0.01)), Case(scaled(design, 100.0), tolerance=1.0))


MODIFIED = table1((0.001, -0.001))
INTERSECTING = intersecting.LARGE, intersecting.STRAIGHT, intersecting.EQUAL.with_parabola(2e-3, -2e-3)
STRONG = table1((0.03, 0.0)), table1((1e6, 0.0))

SITUATIONS = (
    Situation(
        "cone angles 0, 1e-16 and 1e-13 deg, of one or both",
        of(PLAIN, with_cones(PLAIN, 0.0, 1e-16), with_cones(PLAIN, 1e-13, 1e-13)),
        ALL,
    ),
    Situation(
        "helix angle of one member 0, 1e-12 deg", late(lambda: one_spur(0.0), lambda: one_spur(1e-12)), ALL
    ),
    Situation(
        "helix angles with the sum 0, axes with an offset",
        of(spur(0.0, 0.0), spur(25.0, -25.0)),
        STATUS,
        "the shaft angle follows from the helix angles",
        checked,
    ),
    Situation(
        "intersecting axes, straight and helical teeth; offset 1e-6 mm",
        of(*INTERSECTING, replace(INTERSECTING[0], pair=replace(INTERSECTING[0].pair, offset=1e-6))),
        ALL,
    ),
    Situation(
        "the same, shaft-angle error of 0.05 deg about the apex at 1.7 m",
        of(turned(Errors(shaft_angle=radians(0.05)))),
        ("status", "first contact"),
        "the path of contact does not meet the right flanks",
    ),
    Situation(
        "the same, 0.05 deg about the pitch point, in plane, out of plane",
        of(*(turned(MeshErrors(**{way: radians(0.05)})) for way in ("in_plane", "out_of_plane"))),
        ALL,
    ),
    Situation(
        "built-in pairs: one on crossed axes, two on intersecting axes",
        of(*map(builtin_design, ("ni-2017", "awd-transfer", "marine-gearbox"))),
        ALL,
    ),
    Situation(
        "parabola coefficients 0, 1e-14, -1e-14 1/mm",
        of(table1(), table1((1e-14, -1e-14)), table1((-1e-14, 0.0)), flanks=("left",)),
        ALL,
    ),
    Situation(
        "parabola that folds the rack",
        of(*STRONG),
        STATUS,
        "parabola must be between -0.0212 and 0.0212 1/mm",
        checked,
    ),
    Situation(
        "shaft angle 1e-2, 1e-6 deg above the smallest one (n_x = 0)",
        late(lambda: folding(1e-2), lambda: folding(1e-6)),
        PATHS,
        "the pair cannot be assembled",
    ),
    Situation(
        "shaft angle 1e-9, 1 deg below the smallest one (n_x = 0)",
        late(*(lambda below=b: at_shaft_angle(held(table1()), fold() - below) for b in (1e-9, 1.0))),
        STATUS,
        "no common normal in this layout: is the shaft angle right?",
    ),
    Situation(
        "shaft angle 1, 0.5 deg", late(lambda: nearly_parallel(1.0), lambda: nearly_parallel(0.5)), PATHS
    ),
    Situation(
        "parallel axes, base helix angles not opposite",
        of(at_shaft_angle(PLAIN, 0.0)),
        STATUS,
        "on parallel axes base helix angles must be opposite",
        in_file("shaft_angle_deg = 15.0", "shaft_angle_deg = 0.0"),
    ),
    Situation(
        "parallel axes, lines of contact",
        of(LINES),
        PATHS[:1],
        "an error of the shaft angle moves the contact to an edge",
    ),
    Situation(
        "the same, 0.01 deg of shaft angle",
        of(tilted(LINES)),
        ("status", "first contact"),
        "the path of contact does not meet the right flanks",
    ),
    Situation(
        "helical pair on parallel axes, errors of offset and axial position",
        of(HELICAL, HELICAL.with_errors(Errors(0.2, 0.0, 0.5, -0.3)), flanks=("right", "left")),
        PATHS[:1],
        "an error of the shaft angle moves the contact to an edge",
    ),
    Situation(
        "the same, tilted by 1e-3, 1e-8 rad",
        of(*(HELICAL.with_errors(Errors(shaft_angle=tilt)) for tilt in (1e-3, 1e-8))),
        ("status", "first contact"),
        "the path of contact does not meet the right flanks",
    ),
    Situation(
        "the same, convex flanks, design with a shaft angle of 0.001 deg",
        of(at_shaft_angle(HELICAL.with_parabola(-5e-4, -5e-4), 0.001)),
        PATHS,
        "the contact ratio is below 1",
    ),
    Situation(
        "parallel axes, one or both flanks convex; 0.01 deg of shaft angle",
        of(LINES.with_parabola(-0.004, 0.0), CONVEX, tilted(CONVEX)),
        PATHS,
        "the contact ratio is below 1",
    ),
    Situation(
        "shaft angle 90 deg",
        late(lambda: right_angled(45.0, 45.0, 3.0, 2.0), lambda: right_angled(75.0, 15.0, 1.0, 1.0)),
        ALL,
    ),
    Situation(
        "negative shaft angle",
        of(at_shaft_angle(table1(), -15.0)),
        STATUS,
        "give the magnitude, the sense follows from the helix angles",
        in_file("shaft_angle_deg = 15.0", "shaft_angle_deg = -15.0"),
    ),
    Situation(
        "helix hands equal, opposite, both left",
        late(lambda: of_hands(20.0, 20.0), lambda: of_hands(30.0, -12.0), lambda: of_hands(-25.0, -10.57)),
        ALL,
    ),
    Situation(
        "path across n_x = 0",
        of(*list(CROSSING.values())[:2]),
        PATHS,
        "the common normal and the common perpendicular form a right angle",
    ),
    Situation("l1 turns back on the path", of(*TURNING.values()), PATHS, "l1 turns back along the path"),
    Situation(
        "line contact, two contacts at one roll: at the minimum",
        lambda: near_the_fold(0.3),
        PATHS,
        "the roll turns back along the path",
    ),
    Situation(
        "the same, at the saddle point",
        lambda: near_the_fold(-0.3),
        PATHS,
        "the roll turns back along the path",
    ),
    Situation(
        "the same, 0.001 mm from the position at which both coincide",
        lambda: near_the_fold(1e-3),
        PATHS,
        "the roll turns back along the path",
    ),
    Situation(
        "undercut: few teeth, negative shift",
        of(*UNDERCUT.values()),
        ALL,
        "use more teeth, more profile shift or a smaller dedendum",
        checked,
    ),
    Situation(
        "tooth pointed at the heel",
        of(POINTED),
        ALL,
        "reduce the profile shift or the addendum",
        checked,
    ),
    Situation(
        "flanks without contact: no common depth, large distance",
        of(APART["no depth"], APART["axial"]),
        STATUS,
        "the path of contact does not meet the right flanks",
    ),
    Situation("one tooth", of(ONE), ALL, "the path ends at this edge"),
    Situation("1000 teeth: gear, both", of(*MANY.values()), ALL),
    Situation("module 0.05, 50 mm", late(lambda: of_module(0.05), lambda: of_module(50.0)), ALL),
    Situation(
        "path moved off the face by an offset, a shaft-angle error",
        of(table1(errors=Errors(offset=1.3)), table1(errors=Errors(shaft_angle=radians(0.05)))),
        ("status", "first contact"),
        "the path of contact does not meet the right flanks",
    ),
    Situation(
        "path off the flank of one member only",
        of(table1(errors=Errors(pinion_axial=60.0)), table1(errors=Errors(gear_axial=-70.0))),
        STATUS,
        "the path of contact does not meet the right flanks",
    ),
    Situation(
        "path in two segments",
        lambda: [Case(case.design, case.flank) for case in SPLIT[:3]],
        PATHS,
        "the path has 2 segments on the flanks",
    ),
    Situation(
        "random pairs whose path earlier versions did not find",
        lambda: [Case(c.design, c.flank) for c in list(LOST.values())[1:4]],
        PATHS,
        "whether something touches earlier is unknown",
        all_notes,
    ),
    Situation(
        "mesh of one cell (5 mm)", lambda: [Case(MODIFIED, f, tolerance=5.0) for f in ("right", "left")], ALL
    ),
    Situation("slender triangles, 1 : 1e4 and more", thin, ALL, "the contact ratio is below 1"),
    Situation("mesh in single precision", of(MODIFIED, flanks=("left",)), ALL, disturbed=single_precision),
    Situation(
        "mesh 10 m from the origin", of(MODIFIED, flanks=("left",)), ALL, disturbed=ten_metres_away, moved=FAR
    ),
    Situation(
        "equal gears, vertices of both meshes equally near", of(meshes.alike(-0.001), meshes.alike(0.0)), ALL
    ),
    Situation(
        "mirrored, members exchanged, lengths x 0.01, x 100",
        lambda: list(symmetric()),
        ALL,
        "the pair cannot be assembled",
    ),
)
