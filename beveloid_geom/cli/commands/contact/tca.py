"""The command `beveloid-geom tca`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ... import results
from ...options import NumberRange, Refusal, flank_option, option, override_options, points_option

if TYPE_CHECKING:
    from ....analysis.pressure import Load

CERTIFY = "Whether anything else of the teeth touches earlier, about a millisecond a position."
FORCE = "Force on one tooth pair along the common normal, for Hertz's ellipses and pressures along the path."
TORQUE = "Torque on the pinion in place of a force; one tooth pair carries it alone."
YOUNG = "Elastic modulus of both members.  [default: 206000, steel]"
POISSON = "Poisson's ratio of both members.  [default: 0.3]"
METHODS = click.Choice(["one-equation", "five-equation"])


def load_of(
    force: float | None, torque: float | None, youngs_modulus_mpa: float | None, poisson: float | None
) -> Load | None:
    """Give the load that options ask for. Raises Refusal for a force beside a torque, and for a material
    without either."""
    from ....analysis.pressure import Load

    if force is not None and torque is not None:
        raise Refusal(["--force and --torque exclude each other: give one of them"])
    material = {"young": youngs_modulus_mpa, "poisson": poisson}
    given = {name: value for name, value in material.items() if value is not None}
    if force is None and torque is None:
        if given:
            raise Refusal(
                ["--youngs-modulus-mpa and --poisson are of a loaded pair: give --force or --torque"]
            )
        return None
    return Load(force, torque, **given)


@results.result_command(
    flank_option,
    points_option(101, "along the path"),
    override_options,
    option(
        "--method", METHODS, METHODS.choices[0], "The paper's five equations are slower, to compare with."
    ),
    option("--force", NumberRange(0.0, 1e12, min_open=True), None, FORCE, "N"),
    option("--torque", NumberRange(0.0, 1e12, min_open=True), None, TORQUE, "NM"),
    option("--youngs-modulus-mpa", NumberRange(1e-3, 1e7), None, YOUNG, "MPA"),
    option("--poisson", NumberRange(0.0, 0.5), None, POISSON, "RATIO"),
    click.option("--certify/--no-certify", default=True, show_default=True, help=CERTIFY),
    csv="one position a row",
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
    """Find the path of contact of a pair of flanks.

    Rolls count from the position in which each member's generating rack is centred; z counts
    from mid-face towards the heel, l1 and l2 along the flank of the member's tool from its pitch line towards
    the member's tip.
    With --force or --torque each position has Hertz's ellipse and greatest pressure, and says which edge
    of a flank the ellipse passes: there the true pressure is greater.
    JSON and CSV give each position a status, and JSON the path: solved, no_common_normal, not_converged,
    off_flank, several_contacts, endless or undefined. Exit status 1 if there is no contact on the flanks,
    or the pair cannot be assembled.
    """
    from ....report.path import contact_report

    try:
        return contact_report(name, design, flank, points, method, certify, load_of(**load))
    except ArithmeticError as error:
        raise click.ClickException(str(error)) from None  # status 1: nothing wrong with the input
