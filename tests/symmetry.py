"""Equivalent pairs: exchanged, mirrored, scaled. Their results must agree."""

from __future__ import annotations

from dataclasses import replace

from beveloid_geom import Design, Errors, Member, Pair

OTHER = {"right": "left", "left": "right"}
"""Flank of the mirror image by flank of the pair."""


def exchanged(design: Design) -> Design:
    """Return the pair with pinion and gear exchanged."""
    pair, errors = design.pair, design.errors
    return Design(
        pinion=design.gear,
        gear=design.pinion,
        pair=Pair(pair.offset, pair.shaft_angle, pair.gear_mounting, pair.pinion_mounting),
        errors=Errors(errors.offset, errors.shaft_angle, errors.gear_axial, errors.pinion_axial),
    )


def mirrored(design: Design) -> Design:
    """Return the mirror image, in which both hands are exchanged."""
    pinion, gear = (replace(m, helix_angle=-m.helix_angle) for m in design.members)
    return replace(design, pinion=pinion, gear=gear)


def scaled(design: Design, factor: float) -> Design:
    """Return the pair with all lengths multiplied by a factor.

    The pair must have no modifications, no given mounting distances, no parabola of a single flank, and the
    apex of its parabolas at 0."""

    def bigger(member: Member) -> Member:
        tool = member.tool
        tool = replace(tool, normal_module=tool.normal_module * factor, parabola=tool.parabola / factor)
        return replace(member, tool=tool, face_width=member.face_width * factor)

    errors = design.errors
    return Design(
        pinion=bigger(design.pinion),
        gear=bigger(design.gear),
        pair=Pair(design.pair.offset * factor, design.pair.shaft_angle),
        errors=Errors(
            errors.offset * factor,
            errors.shaft_angle,
            errors.pinion_axial * factor,
            errors.gear_axial * factor,
        ),
    )
