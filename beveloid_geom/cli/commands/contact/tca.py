"""The command `beveloid-geom tca`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ... import results
from ...options import NumberRange, Refusal, flank_option, no_result, option, override_options, points_option

if TYPE_CHECKING:
    from ....analysis.pressure import Load

FORCE = (
    "Force on one tooth pair along the common normal, for contact ellipses and pressures (Hertz)."
    " On parallel axes it is the total force on all lines of contact."
)
TORQUE = "Torque on the pinion in N m, instead of a force."


def load_of(
    force: float | None, torque: float | None, youngs_modulus_mpa: float | None, poisson: float | None
) -> Load | None:
    """Return the load of the options. Raises Refusal for both force and torque, and for material data without
    a load."""
    from ....analysis.pressure import Load

    if force is not None and torque is not None:
        raise Refusal(["--force and --torque exclude each other: give one of them"])
    material = {"young": youngs_modulus_mpa, "poisson": poisson}
    given = {name: value for name, value in material.items() if value is not None}
    if force is None and torque is None:
        if given:
            raise Refusal(["--youngs-modulus-mpa and --poisson need a load: give --force or --torque"])
        return None
    return Load(force, torque, **given)


@results.result_command(
    flank_option,
    points_option(101, "along the path"),
    override_options,
    option(
        "--method",
        click.Choice(["one-equation", "five-equation"]),
        "one-equation",
        "Method: one equation, or for comparison the five equations of the paper, which are slower, give the"
        " same path, and cannot solve line contact.",
    ),
    option("--force", NumberRange(0.0, 1e12, min_open=True), None, FORCE, "N"),
    option("--torque", NumberRange(0.0, 1e12, min_open=True), None, TORQUE, "NM"),
    option(
        "--youngs-modulus-mpa",
        NumberRange(1e-3, 1e7),
        None,
        "Young's modulus of both members; outside 500 to 1,000,000 MPa, a warning is printed."
        "  [default: 206000, steel]",
        "MPA",
    ),
    option(
        "--poisson", NumberRange(0.0, 0.5), None, "Poisson's ratio of both members.  [default: 0.3]", "RATIO"
    ),
    click.option(
        "--certify/--no-certify",
        default=True,
        show_default=True,
        help="Check whether other teeth or edges touch earlier; this takes about 1 ms per position.",
    ),
    csv="one position per row",
)
def tca(
    name: str,
    design: results.Design,
    flank: str,
    points: int,
    method: str,
    certify: bool,
    **load: float | None,
) -> results.Result:
    """Compute the path of contact of a pair of flanks.

    The roll angle of a member is 0 where its tooth 0 points along the common perpendicular towards the axis
    of the other member (phi = 0 in Eq. 6). z is measured from mid-face, l1 and l2 along the tool flank from
    the apex of its parabola towards the tip of the member. The transmission error is positive where the gear
    is ahead. With --force or --torque, the contact ellipse and the largest pressure (Hertz) are computed at
    each position. If an ellipse extends beyond an edge of a flank, this edge is named; the true pressure is
    then larger. On parallel axes the load is distributed evenly over all lines of contact. JSON and CSV
    contain the status of each position: solved, no_common_normal, not_converged, off_flank, several_contacts
    (more than one contact at this l1) or undefined (the inputs define no problem). JSON also contains the
    status of the path, which can be endless (a closed curve on the flanks), but not several_contacts. The
    exit status is 1 if there is no contact on the flanks or the pair cannot be assembled, 4 if the path could
    not be computed."""
    from ....report.path import contact_report
    from ....status import NotComputed

    try:
        return contact_report(name, design, flank, points, method, certify, load_of(**load))
    except ArithmeticError as error:
        raise no_result(NotComputed(error)) from None
