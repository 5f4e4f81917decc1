"""Intersection of flank and fillet of undercut members against 50 digits."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest
from mpmath import MPContext

from beveloid_geom import Member, Tool
from beveloid_geom.arrays import FloatArray, flank_sign
from beveloid_geom.gear.fillet import tool_round
from beveloid_geom.gear.tooth_side import undercut_edge
from beveloid_geom.validation.five_equations_mp import Mpf

MP = MPContext()
MP.dps = 50


def drawn(count: int) -> list[Member]:
    """Return random members with few teeth: spur and helical, cylindrical and conical, with and without
    parabola."""
    rng, members = np.random.default_rng(28), []
    for k in range(count):
        module = float(rng.choice([1.0, 2.0, 5.0]))
        parabola = rng.uniform(-1.5e-3, 1.5e-3) / module if k % 3 == 0 else 0.0
        helix, cone = radians(rng.uniform(-25.0, 25.0)), radians(rng.uniform(-8.0, 8.0))
        tool = Tool(module, radians(20.0), parabola=parabola)
        shift, face = rng.uniform(-0.1, 0.2), module * rng.uniform(5.0, 12.0)
        members.append(Member(tool, int(rng.integers(11, 17)), helix, cone if k % 2 else 0.0, shift, face))
    return members


def exact(member: Member, flank: str, z: float, start: float, end: float) -> tuple[float, float]:
    """Return l and radius (mm) at which flank and fillet have the same radius and angle in the plane `z`,
    with 50 digits from Eqs. 1 to 6. The search starts at estimates (mm) of the profile coordinates
    at which the flank starts (`start`) and the fillet ends (`end`)."""
    tool, sigma, rounding = member.tool, flank_sign(flank), tool_round(member.tool, flank)
    alpha, beta, gamma = map(MP.mpf, (tool.normal_pressure_angle, member.helix_angle, member.cone_angle))
    module, a, rho = MP.mpf(tool.normal_module), MP.mpf(tool.parabola), MP.mpf(rounding.radius)
    across = -MP.sin(gamma) * MP.sin(beta), MP.cos(beta), -MP.cos(gamma) * MP.sin(beta)
    along = MP.cos(gamma), MP.mpf(0), -MP.sin(gamma)
    trace = MP.cos(beta) * MP.sin(gamma), MP.sin(beta), MP.cos(beta) * MP.cos(gamma)
    pitch, joint = module * member.teeth / (2 * MP.cos(beta)), MP.mpf(rounding.joint)

    def met(x_n: Mpf, y_n: Mpf, nx_n: Mpf, ny_n: Mpf) -> tuple[Mpf, Mpf]:
        """Return r^2 and angle of the generated point for a point of the section and its normal."""
        point = [x_n * e + y_n * f for e, f in zip(along, across, strict=True)]
        point[0] += member.profile_shift * module
        normal = [nx_n * e + ny_n * f for e, f in zip(along, across, strict=True)]
        u = (z - point[2]) / trace[2]
        x_c, y_c = point[0] + u * trace[0], point[1] + u * trace[1]
        y = normal[1] / normal[0] * x_c
        return (pitch + x_c) ** 2 + y**2, (y_c - y) / pitch + MP.atan2(y, pitch + x_c)

    def of_section(p: Mpf, q: Mpf, tau: Mpf) -> tuple[Mpf, Mpf]:
        """Return r^2 and angle of the generated point for coordinates along the straight flank and its
        normal."""
        x = p * MP.cos(alpha) + q * MP.sin(alpha)
        y = sigma * (q * MP.cos(alpha) - p * MP.sin(alpha) + MP.pi * module / 4)
        return met(x, y, MP.sin(alpha - tau), sigma * MP.cos(alpha - tau))

    turn = MP.atan(2 * a * joint)
    centre = joint - rho * MP.sin(turn), a * joint**2 + rho * MP.cos(turn)

    def apart(l: Mpf, tau: Mpf) -> list[Mpf]:
        on_flank = of_section(l, a * l**2, MP.atan(2 * a * l))
        on_fillet = of_section(centre[0] + rho * MP.sin(tau), centre[1] - rho * MP.cos(tau), tau)
        return [on_flank[0] - on_fillet[0], on_flank[1] - on_fillet[1]]

    l, _ = MP.findroot(apart, (start, turn + (end - joint) / rho), tol=1e-70)
    return float(l), float(MP.sqrt(of_section(l, a * l**2, MP.atan(2 * a * l))[0]))


def test_intersection_against_50_digits(flank: str) -> None:
    edges = [(member, edge) for member in drawn(40) if (edge := undercut_edge(member, flank)) is not None]
    assert len(edges) >= 20
    for member, part in [(member, part) for member, edge in edges for part in edge.parts]:
        z = part.low + (part.high - part.low) * np.array([0.03, 0.3, 0.71, 0.98])
        rows: FloatArray = part.rows(z)[:, 0]
        for plane, start, end, radius in zip(z.tolist(), *rows.tolist(), strict=True):
            l, r = exact(member, flank, plane, start, end)
            assert radius == pytest.approx(r, abs=1e-11 * float(member.tool.normal_module))
            assert start == pytest.approx(l, abs=1e-6)
