"""The pair in contact as an input that CalculiX runs as it is (.inp), whose keywords are Abaqus's, too.

Hubs follow one reference node each, on the member's axis, by a kinematic coupling. The first step turns the
pinion into contact, by about what the torque will; from an open gap a torque finds nothing to push against.
In the second the pinion's reference node is free to turn about its axis and carries the torque, the gear's
stays held. Printed are the force of each tooth pair, its moment about the origin of S_f and its centre,
reactions at the reference nodes, and how a gauge on either hub moves, which says how far it has turned.

CalculiX takes four letters of CDISP and CSTRESS; CFN is a force with its moment there, in Abaqus without.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from ...arrays import flank_sign
from ...design.model import Design
from ...export import MEMBERS, identifier
from .abaqus import STEEL, write_model
from .pair_mesh import ELEMENT, PairMesh, lever_of

PENALTY = 1e6
"""N/mm^3: contact that gives way by 1 um at 1000 MPa. With ten times as much pressures are patchy: elements
that are much longer than wide follow neither flank nor indentation within 0.1 um."""
STIFFNESS = 14e3
"""N/mm^2: of teeth in mesh for each mm of face (ISO 6336-1), to guess how far the pinion turns."""
LEAD = "pair in contact: "
"""Begins the line of the header that tells programs what the deck is of, as JSON."""


def write_pair_deck(
    path: Path,
    design: Design,
    pair: PairMesh,
    torque: float,
    comment: Sequence[str] = (),
    decks: int = 1,
) -> None:
    """Write the deck of a `torque` (N mm, above 0) on the pinion, one of so many `decks` over a pitch; lines
    of `comment` go into the header."""
    told = json.dumps({**facts_of(pair, torque), "decks": decks})
    write_model(path, pair.mesh, ELEMENT, _history(design, pair, torque), (*comment, LEAD + told))


def facts_of(pair: PairMesh, torque: float) -> dict[str, object]:
    """Give what is needed beside CalculiX's numbers to read them: rad, N mm, mm in S_f."""
    gauges = {name: pair.mesh.points[pair.mesh.node_sets[f"{name} gauge"][0]].tolist() for name in MEMBERS}
    return {
        "flank": pair.flank,
        "pinion_roll": float(pair.roll[0]),
        "gear_roll": float(pair.roll[1]),
        "torque": torque,
        "pairs": [[identifier(name) for name in both] for both in pair.contacts],
        "axes": [frame[0][:, 2].tolist() for frame in pair.frames],
        "origins": [frame[1].tolist() for frame in pair.frames],
        "gauges": list(gauges.values()),
    }


def _history(design: Design, pair: PairMesh, torque: float) -> Iterator[str]:
    yield STEEL
    for name in MEMBERS:
        yield f"*SURFACE, NAME={name}_hub_nodes, TYPE=NODE\n{name}_hub\n"
        yield f"*COUPLING, CONSTRAINT NAME={name}, REF NODE={pair.mesh.node_sets[f'{name} reference'][0] + 1}"
        yield f", SURFACE={name}_hub_nodes\n*KINEMATIC\n1, 3\n"
    yield "*SURFACE INTERACTION, NAME=flanks\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n"
    yield f"{PENALTY:g},\n"
    contacts = [tuple(identifier(name) for name in both) for both in pair.contacts]
    for pinion, gear in contacts:
        yield f"*CONTACT PAIR, INTERACTION=flanks, TYPE=SURFACE TO SURFACE\n{pinion}, {gear}\n"
    lever, sense = lever_of(design), flank_sign(pair.flank)
    face = min(float(member.face_width) for member in design.members)
    turn = torque / (lever * lever * face * STIFFNESS)
    held = "gear_reference, 1, 6\npinion_reference, 1, 5\n"
    yield f"** The pinion is turned into contact.\n*STEP, INC=50\n*STATIC\n1., 1.\n*BOUNDARY\n{held}"
    yield f"pinion_reference, 6, 6, {sense * turn:.9g}\n*END STEP\n"
    yield f"** The torque takes over.\n*STEP, INC=50\n*STATIC\n1., 1.\n*BOUNDARY, OP=NEW\n{held}"
    yield f"*CLOAD\npinion_reference, 6, {sense * torque:.12g}\n"
    for name in MEMBERS:
        yield f"*NODE PRINT, NSET={name}_reference\nRF\n*NODE PRINT, NSET={name}_gauge\nU\n"
    for pinion, gear in contacts:
        yield f"*CONTACT PRINT, SLAVE={pinion}, MASTER={gear}\nCFN\n"
    yield "*NODE FILE\nU\n*EL FILE\nS\n*CONTACT FILE\nCDISP, CSTRESS\n*END STEP\n"
