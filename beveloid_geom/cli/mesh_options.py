"""Options of `beveloid-geom mesh`."""

from __future__ import annotations

from pathlib import Path

import click

from .mesh_parts import FLANKS, GEARS, TEETH
from .options import BUILTIN_DESIGN, SIDES, block, option, override_options

PARTS = (*GEARS, "pair", *FLANKS, *TEETH)
"""Parts that can be written."""
mesh_options = block(
    click.argument("design", default=BUILTIN_DESIGN),
    click.option("--part", type=click.Choice(PARTS), help="Part that is written."),
    click.option(
        "--out",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="Output file; its suffix determines the format.",
    ),
    click.option(
        "--placed",
        is_flag=True,
        help="Write a single gear, tooth or flank in its position in the pair, not in the frame of its gear."
        " If there are several teeth, the middle one is in mesh.",
    ),
    click.option(
        "--frames",
        is_flag=True,
        help="Print the positions of the gears in mesh, as matrices from their frames to S_f. Without --part"
        " and --out, no file is written.",
    ),
    option(
        "--tolerance",
        float,
        None,
        "Largest distance of the mesh from the exact surfaces; for hexahedra, of their straight edges."
        "  [default: module / 600 (0.01 mm at module 6 mm); .glb: module / 200 (0.03 mm); hexahedra:"
        " module / 120 (0.05 mm). Without this option, the pair as .inp has a fine mesh on flanks in"
        " contact and a coarse mesh elsewhere]",
        "MM",
    ),
    option(
        "--flank",
        SIDES,
        SIDES.choices[0],
        "Flank that is written; for the pair and a loaded tooth, the flank in contact.",
    ),
    click.option(
        "--field",
        type=click.Choice(["separation", "pattern"]),
        multiple=True,
        help="Write the distance of the mating flank at each point of a flank, mm. separation: at the roll in"
        " the middle of the path of contact; pattern: the smallest distance while the tooth passes"
        " through the mesh. Can be repeated.",
    ),
    option(
        "--teeth",
        click.IntRange(1),
        None,
        "Number of neighbouring teeth, up to the complete gear. In a .inp file they are held in the bore"
        " and at their cut sides: use 3 for stresses. For the pair in contact, the number must be odd."
        "  [default: 1, for the pair 3]",
        "K",
    ),
    option(
        "--bore-radius",
        float,
        None,
        "Radius of the bore; for the pair, of both gears.  [default: 0.45 of the smallest root radius]",
        "MM",
    ),
    option("--pinion-bore-radius", float, None, "Radius of the pinion's bore in the pair.", "MM"),
    option("--gear-bore-radius", float, None, "Radius of the gear's bore in the pair.", "MM"),
    option(
        "--element",
        click.Choice(["C3D20", "C3D20R", "C3D8I", "C3D8"]),
        "C3D20",
        "Type of the elements. C3D20R allows hourglass modes where the contact is smaller than an"
        " element, C3D8I fails the patch test where elements are distorted, and C3D8 is too stiff in"
        " bending.",
    ),
    option(
        "--load",
        float,
        None,
        "Force on the flank along its normal. It is applied as Hertzian pressure on the contact ellipse of"
        " steel gears in the middle of the path.  [default: 1000 * (module / 6 mm)^2]",
        "N",
    ),
    option(
        "--torque",
        float,
        None,
        "Torque on the pinion of the pair as .inp, in N m; the gear is held.  "
        "[default: the torque of a force of 20 kN * (module / 6 mm)^2 between the teeth]",
        "NM",
    ),
    option(
        "--across",
        float,
        4.0,
        "Number of elements across the contact ellipse or strip of the pair as .inp: 4 for pressures, 1 for"
        " load sharing and transmission error.",
        "N",
    ),
    option(
        "--roll-deg",
        float,
        None,
        "Roll of the pinion; the gear is turned until the first tooth touches. For the pair, for a part"
        " with --placed and for --frames.  [default: the middle of the path of contact]",
        "DEG",
    ),
    option(
        "--rolls",
        click.IntRange(1, 1000),
        None,
        "Number of roll angles of the pinion over one pitch, around the middle of the path of contact, for"
        " the pair as .inp. Each has its file: pair-1.inp, pair-2.inp ... Not with --roll-deg.",
        "N",
    ),
    override_options,
    click.pass_context,
)
