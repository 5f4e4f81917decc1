"""Positions of a path solved again at 60 digits, by `validation.five_equations_mp`."""

from __future__ import annotations

from beveloid_geom import ContactPath
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.validation.five_equations_mp import MP, ContactMp, Mpf, solve_mp

SIX = ("l1", "u1", "l2", "u2", "pinion_roll", "gear_roll")


def numbers_of(path: ContactPath, k: int) -> tuple[float, float, float, float, float, float]:
    """Return the six unknowns of Eq. 15 at position `k`: l1, u1, l2, u2 (mm), rolls of pinion and gear
    (rad)."""
    l1, u1, l2, u2, pinion_roll, gear_roll = (float(getattr(path, name)[k]) for name in SIX)
    return l1, u1, l2, u2, pinion_roll, gear_roll


def exact_at(
    path: ContactPath, k: int, held: str = "phi1", mounting: tuple[Mpf, Mpf] | None = None
) -> ContactMp:
    """Return the contact at the pinion roll of position `k`, or at its l1 if "l1" is `held`; with the
    mounting distances of the library if none are given."""
    guess = numbers_of(path, k)
    first, second = mounting or map(MP.mpf, mounting_of(path.design).distance.tolist())
    return solve_mp(path.design, path.flank, guess, (held, guess[0 if held == "l1" else 4]), (first, second))


def off_by(
    path: ContactPath, k: int, held: str = "phi1", mounting: tuple[Mpf, Mpf] | None = None
) -> tuple[float, float]:
    """Return the largest differences of position `k` from the exact one: of its six unknowns and its point
    (mm, rad), and of its normal."""
    exact = exact_at(path, k, held, mounting)
    ours = (*numbers_of(path, k), *path.point[k])
    true = (exact.l1, exact.u1, exact.l2, exact.u2, exact.phi1, exact.phi2, *exact.point)
    apart, turned = (
        max(abs(float(e - x)) for e, x in zip(*both, strict=True))
        for both in ((true, ours), (exact.normal, path.normal[k]))
    )
    return apart, turned
