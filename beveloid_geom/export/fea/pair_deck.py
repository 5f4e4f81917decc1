"""Input file of the pair in contact (.inp) that CalculiX runs as it is. Abaqus has the same keywords.

The hub of each member follows a reference node on its axis by a kinematic coupling. A torque needs contact to
act against, so that the load comes in two steps:

1. The pinion is turned into contact, by about the angle that the torque will produce.
2. The pinion's reference node is free to turn about its axis and carries the torque. The gear's is held.

The output has, for each tooth pair, the contact force, its moment about the origin of S_f and its centre; the
reactions at the reference nodes; and the displacement of a gauge node on each hub, from which its rotation
follows.

CDISP and CSTRESS are the names in Abaqus. CalculiX calls them CDIS and CSTR, and accepts the long names. CFN
includes the moment of the force in CalculiX, but not in Abaqus."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from ...arrays import MEMBERS, flank_sign
from ...design.model import Design
from ...export import identifier
from .abaqus import STEEL, write_model
from .pair_mesh import ELEMENT, PairMesh, force_lever

FACTS_MARK = "pair in contact: "
"""Start of the header line with the data, as JSON, that `pair_results` needs."""


def write_pair_deck(
    path: Path,
    design: Design,
    pair: PairMesh,
    torque: float,
    comment: Sequence[str] = (),
    decks: int = 1,
) -> None:
    """Write the deck of a pair in contact.

    Parameters
    ----------
    path : Path
        File to write.
    design : Design
        A single design.
    pair : PairMesh
        Its mesh.
    torque : float
        Torque on the pinion, N mm, above 0.
    comment : sequence of str
        Lines for the header.
    decks : int
        Number of decks over one pitch to which this deck belongs.
    """
    facts = json.dumps({**facts_of(pair, torque), "decks": decks})
    write_model(path, pair.mesh, ELEMENT, _history(design, pair, torque), (*comment, FACTS_MARK + facts))


def facts_of(pair: PairMesh, torque: float) -> dict[str, object]:
    """Return the data that `pair_results` needs besides the output of CalculiX: rad, N mm, and mm in S_f."""
    gauges = [pair.mesh.points[pair.mesh.node_sets[f"{name} gauge"][0]].tolist() for name in MEMBERS]
    return {
        "flank": pair.flank,
        "pinion_roll": float(pair.roll[0]),
        "gear_roll": float(pair.roll[1]),
        "torque": torque,
        "pairs": [[identifier(name) for name in both] for both in pair.contacts],
        "axes": [frame[0][:, 2].tolist() for frame in pair.frames],
        "origins": [frame[1].tolist() for frame in pair.frames],
        "gauges": gauges,
    }


def _history(design: Design, pair: PairMesh, torque: float) -> Iterator[str]:
    """Yield the lines after the mesh: material, couplings, contact and the two steps."""
    # N/mm^2: single stiffness c' = 14 N/(mm um) of a tooth pair per mm of face width (ISO 6336-1), for the
    # estimate of the rotation.
    single_stiffness = 14e3
    yield STEEL
    for name in MEMBERS:
        yield f"*SURFACE, NAME={name}_hub_nodes, TYPE=NODE\n{name}_hub\n"
        yield f"*COUPLING, CONSTRAINT NAME={name}, REF NODE={pair.mesh.node_sets[f'{name} reference'][0] + 1}"
        yield f", SURFACE={name}_hub_nodes\n*KINEMATIC\n1, 3\n"
    yield "*SURFACE INTERACTION, NAME=flanks\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n"
    yield f"{pair.stiffness:.6g},\n"
    contacts = [tuple(identifier(name) for name in both) for both in pair.contacts]
    for pinion, gear in contacts:
        yield f"*CONTACT PAIR, INTERACTION=flanks, TYPE=SURFACE TO SURFACE\n{pinion}, {gear}\n"
    lever, sense = force_lever(design), flank_sign(pair.flank)
    face = min(float(member.face_width) for member in design.members)
    turn = torque / (lever * lever * face * single_stiffness)
    held = "gear_reference, 1, 6\npinion_reference, 1, 5\n"
    # Beginning of a step: initial increment, duration, smallest and largest increment.
    step_text = "*STEP, INC=50\n*STATIC\n1., 1., 1e-6, 1.\n"
    yield f"** The pinion is turned into contact.\n{step_text}*BOUNDARY\n{held}"
    yield f"pinion_reference, 6, 6, {sense * turn:.9g}\n*END STEP\n"
    yield f"** The torque replaces the prescribed rotation.\n{step_text}*BOUNDARY, OP=NEW\n{held}"
    yield f"*CLOAD\npinion_reference, 6, {sense * torque:.12g}\n"
    for name in MEMBERS:
        yield f"*NODE PRINT, NSET={name}_reference\nRF\n*NODE PRINT, NSET={name}_gauge\nU\n"
    for pinion, gear in contacts:
        yield f"*CONTACT PRINT, SLAVE={pinion}, MASTER={gear}\nCFN\n"
    yield "*NODE FILE\nU\n*EL FILE\nS\n*CONTACT FILE\nCDISP, CSTRESS\n*END STEP\n"
