"""A flank with its fillet as one surface, and which of its points has a given radius.

Profile coordinate s. Down to the joint with the tool's tip round s is the flank parameter `l`;
below it s falls by the round's radius times the angle by which the section normal has turned (a
tenth of a module, if the tool has less of a round), to `bottom`, where the bottom land begins. In
the rack's section let p run along the straight flank and q along its normal; with the unit normal
(-sin(tau), cos(tau)) in (p, q)

    flank     p = l,                   q = a l^2,                tan(tau) = 2 a l
    fillet    p = p_c + rho sin(tau),  q = q_c - rho cos(tau),   tau' = 1 / rho

and the slope k = n_y / n_x of Eq. 6 has k' = tau' (d x m)_z / n_x^2 on both, d and m being the
directions of p and q. The trace parameter u is eliminated: the rack is carried along its trace
into the plane z. Hence r^2 and the angle are explicit in (s, z), and s follows from r^2 in closed
form (no parabola) or by Newton.

Surfaces are continued beyond their tip cone, toe and heel. Nothing is cut twice: on an undercut
member, whose fillet reaches into the flank, `Surface.undercut` is set.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..design.model import Member
from ..support.read_only import kept
from .fillet import tool_round
from .flank import highest_parameter, tip_radius
from .rack import Numbers, rack_of

LEAST_SCALE = 0.1
"""Modules: least length for which the profile coordinate counts one rad of the fillet."""
PASSES, FILLET_PASSES = 14, 80
LAST_STEP = 1e-8
"""Share of the flank's depth, or of the fillet's scale. A Newton step below it is the last: it leaves an
error of its square over a radius."""


@dataclass(frozen=True, eq=False)
class Surface:
    """One flank of a single member with its fillet, as one surface over (s, z).

    `apex`, `along`, `out` (2,): apex and the directions of p and q, carried along the trace into
    the plane z = 0, components x and y of S_c; `trace` (2,): what they gain per mm of z;
    `direction`, `normal` (3,) of the rack; `twist` is (d x m)_z. `joint` and `bottom` are the
    profile coordinates (mm) where flank and fillet end, `turn` is tau (rad) at the joint,
    `centre` (p, q) and `radius` (mm) the tool's round, `scale` the mm of s for a rad of it.
    `tip` (mm) at mid-face and `taper` give the tip cone, `root` and `root_taper` the root cone,
    `half_width` (mm) toe and heel. `undercut`: the radius does not rise all along s."""

    sigma: float
    parabola: float
    pitch_radius: float
    apex: FloatArray
    along: FloatArray
    out: FloatArray
    trace: FloatArray
    direction: FloatArray
    normal: FloatArray
    twist: float
    joint: float
    bottom: float
    turn: float
    centre: tuple[float, float]
    radius: float
    scale: float
    highest: float
    tip: float
    taper: float
    half_width: float
    root: float = 0.0
    root_taper: float = 0.0
    undercut: bool = False


@dataclass(frozen=True, eq=False)
class Cut:
    """Points of a surface where the rack cuts them, before they turn by `phi` (rad): `x`, `y` (mm)
    and the unit normal (`nx`, `ny`, `nz`), and derivatives by s (`_s`) and by z (`_z`). Real or
    complex arrays; at the joint derivatives are those of the flank."""

    x: Numbers
    y: Numbers
    phi: Numbers
    nx: Numbers
    ny: Numbers
    nz: Numbers
    x_s: Numbers
    y_s: Numbers
    phi_s: Numbers
    x_z: float
    y_z: Numbers
    phi_z: Numbers

    @property
    def square(self) -> Numbers:
        """r^2, mm^2."""
        return np.asarray(self.x * self.x + self.y * self.y)

    @property
    def square_s(self) -> Numbers:
        """Derivative of r^2 by s, mm."""
        return np.asarray(2.0 * (self.x * self.x_s + self.y * self.y_s))

    @property
    def square_z(self) -> Numbers:
        """Derivative of r^2 by z, mm."""
        return np.asarray(2.0 * (self.x * self.x_z + self.y * self.y_z))


@dataclass(frozen=True, eq=False)
class Bends:
    """Second derivatives of a `Cut` by s, and by s and z. Those by z are zero: points move evenly along z."""

    x_ss: FloatArray
    y_ss: FloatArray
    phi_ss: FloatArray
    y_sz: FloatArray
    phi_sz: FloatArray


def _surface(member: Member, flank: str) -> Surface:
    rack, rounding, tool = rack_of(member, flank), tool_round(member.tool, flank), member.tool
    a, radius = float(tool.parabola), rounding.radius
    tx, ty, tz = rack.trace
    trace = np.array((tx / tz, ty / tz))
    turn = float(np.arctan(2.0 * a * rounding.joint))
    scale = max(radius, LEAST_SCALE * float(tool.normal_module))
    d, m = rack.direction, rack.normal
    surface = Surface(
        sigma=rack.sigma,
        parabola=a,
        pitch_radius=float(rack.pitch_radius),
        apex=rack.apex[:2] - rack.apex[2] * trace,
        along=d[:2] - d[2] * trace,
        out=m[:2] - m[2] * trace,
        trace=trace,
        direction=d,
        normal=m,
        twist=float(d[0] * m[1] - d[1] * m[0]),
        joint=rounding.joint,
        bottom=rounding.joint - scale * (0.5 * np.pi - rounding.angle),
        turn=turn,
        centre=(rounding.joint - radius * np.sin(turn), a * rounding.joint**2 + radius * np.cos(turn)),
        radius=radius,
        scale=scale,
        highest=float(highest_parameter(member)),
        tip=float(tip_radius(member, 0.0)),
        taper=float(np.tan(member.cone_angle)),
        half_width=0.5 * float(member.face_width),
    )
    low, joint = surface.bottom, surface.joint
    s = np.append(low + (joint - low) * np.linspace(0.02, 1.0, 25), np.linspace(joint, surface.highest, 25))
    z = surface.half_width * np.linspace(-1.0, 1.0, 9)[:, None]
    rises = bool((cut_at(surface, s, z).square_s > 0.0).all())
    root = cut_at(surface, np.array([low, low]), np.array([0.0, 1.0])).x
    return replace(surface, root=float(root[0]), root_taper=float(root[1] - root[0]), undercut=not rises)


_kept_surface = kept(64)(_surface)


def surface_of(member: Member, flank: str) -> Surface:
    """Make the `flank` ('right' or 'left') of a single member with its fillet.

    Raises ValueError for a member of arrays, and as `fillet.tool_round` does."""
    if any(np.ndim(value) for value in (*vars(member.tool).values(), *vars(member).values())):
        raise ValueError("separations need members of single numbers; only pair and errors may be arrays")
    return _kept_surface(member, flank)


def _section(surface: Surface, s: Numbers) -> tuple[Numbers, ...]:
    """Find p, q, sin(tau), cos(tau), tau' and the derivatives of p and q at profile coordinates s."""
    a, joint = surface.parabola, surface.joint
    on_fillet = s.real < joint
    low = bool(on_fillet.any())
    l = np.where(on_fillet, joint, s) if low else s
    if a == 0.0 and not low:
        zero, one = np.zeros_like(l), np.ones_like(l)
        return l, zero, zero, one, zero, one, zero
    bend = 2.0 * a * l
    cos = 1.0 / np.sqrt(1.0 + bend * bend)
    values = [l, 0.5 * bend * l, bend * cos, cos, 2.0 * a * cos * cos, np.ones_like(l), bend]
    if low:
        rate, rho = 1.0 / surface.scale, surface.radius
        tau = surface.turn + (s[on_fillet] - joint) * rate
        sin, cos = np.sin(tau), np.cos(tau)
        p, q = surface.centre[0] + rho * sin, surface.centre[1] - rho * cos
        for array, part in zip(
            values, (p, q, sin, cos, rate, rho * rate * cos, rho * rate * sin), strict=True
        ):
            array[on_fillet] = part
    return tuple(values)


def cut_at(surface: Surface, s: Numbers, z: Numbers) -> Cut:
    """Find points, normals and derivatives at profile coordinates `s` in the planes `z`, mm."""
    return _cut(surface, _section(surface, s), z)


def cut_with_bends(surface: Surface, s: FloatArray, z: FloatArray) -> tuple[Cut, Bends]:
    """Find the same, and second derivatives by s."""
    section = _section(surface, s)
    cut, (_, _, sin, cos, turn_s, p_s, q_s) = _cut(surface, section, z), section
    # Along the flank q' = 2 a l grows, and tau' = 2 a cos^2(tau); on the fillet tau' stays.
    p_ss, q_ss, turn_ss = np.zeros(1), np.full(1, 2.0 * surface.parabola), -2.0 * q_s * turn_s * turn_s
    low = s < surface.joint
    if low.any():
        p_ss, q_ss = np.where(low, -q_s * turn_s, p_ss), np.where(low, p_s * turn_s, q_ss)
        turn_ss = np.where(low, 0.0, turn_ss)
    (bx, by), (cx, cy) = surface.along, surface.out
    slope, rate = cut.ny / cut.nx, surface.twist / (cut.nx * cut.nx)
    nx_s, slope_s = -turn_s * (sin * surface.normal[0] + cos * surface.direction[0]), rate * turn_s
    slope_ss = rate * turn_ss - 2.0 * slope_s * nx_s / cut.nx
    x_ss, r = p_ss * bx + q_ss * cx, surface.pitch_radius
    y_ss = slope_ss * (cut.x - r) + 2.0 * slope_s * cut.x_s + slope * x_ss
    y_sz = slope_s * cut.x_z
    return cut, Bends(x_ss, y_ss, (p_ss * by + q_ss * cy - y_ss) / r, y_sz, -y_sz / r)


def cut_with_turn(surface: Surface, s: FloatArray, z: FloatArray) -> tuple[Cut, FloatArray]:
    """Find where the rack cuts the surface, and the derivatives (3, n) of the unit normal by s."""
    section = _section(surface, s)
    sin, cos, turn_s = section[2:5]
    sin, cos = turn_s * sin, turn_s * cos
    rates = [-(sin * m + cos * d) for d, m in zip(surface.direction, surface.normal, strict=True)]
    return _cut(surface, section, z), np.array(rates)


def _cut(surface: Surface, section: tuple[Numbers, ...], z: Numbers) -> Cut:
    """Find where the rack cuts a surface from what `_section` finds."""
    p, q, sin, cos, turn_s, p_s, q_s = section
    (ax, ay), (bx, by), (cx, cy), (ex, ey) = surface.apex, surface.along, surface.out, surface.trace
    (dx, dy, dz), (mx, my, mz) = surface.direction, surface.normal
    nx, ny = cos * mx - sin * dx, cos * my - sin * dy
    slope = ny / nx
    x_c, y_c = ax + p * bx + q * cx + z * ex, ay + p * by + q * cy + z * ey
    x_s, y_cs = p_s * bx + q_s * cx, p_s * by + q_s * cy
    y, y_s = slope * x_c, turn_s * surface.twist / (nx * nx) * x_c + slope * x_s
    r = surface.pitch_radius
    return Cut(
        x=r + x_c,
        y=y,
        phi=(y_c - y) / r,
        nx=nx,
        ny=ny,
        nz=cos * mz - sin * dz,
        x_s=x_s,
        y_s=y_s,
        phi_s=(y_cs - y_s) / r,
        x_z=float(ex),
        y_z=slope * ex,
        phi_z=(ey - slope * ex) / r,
    )


def angle_of(cut: Cut) -> FloatArray:
    """Find angles (rad) about the own axis of real points, own frame."""
    return np.asarray(cut.phi + np.arctan2(cut.y, cut.x))


def profile_at(surface: Surface, square: FloatArray, z: FloatArray) -> FloatArray:
    """Find the profile coordinate s (mm) of the points with r^2 = `square` (mm^2) in the planes `z`, arrays
    of one axis. NaN where the surface has none; the caller silences NumPy's warnings."""
    s = _straight_profile(surface, square, z)
    if surface.parabola != 0.0:
        s = _bent_profile(surface, s, square, z)
    low = np.flatnonzero(~(s >= surface.joint) & ~np.isnan(square + z))
    if low.size:
        s[low] = _fillet_profile(surface, square[low], z[low])
    return s


def _straight_profile(surface: Surface, square: FloatArray, z: FloatArray) -> FloatArray:
    """Find s on the flank without parabola: r^2 is quadratic in x_c. NaN below the base cylinder."""
    r, slope = surface.pitch_radius, surface.normal[1] / surface.normal[0]
    spread = 1.0 + slope * slope
    excess = square - r * r
    # The root above the base cylinder, free of cancellation near the pitch cylinder.
    x_c = excess / (r + np.sqrt(r * r + spread * excess))
    return np.asarray((x_c - surface.apex[0] - z * surface.trace[0]) / surface.along[0])


def _bent_profile(surface: Surface, s: FloatArray, square: FloatArray, z: FloatArray) -> FloatArray:
    """Solve by Newton from the straight flank. What falls below the joint is left to the fillet."""
    low, high = surface.joint, 2.0 * surface.highest - surface.joint
    last = LAST_STEP * (surface.highest - surface.joint)
    s = np.where(np.isnan(s), low, np.minimum(np.maximum(s, low), high))
    a, bend = surface.parabola, 2.0 * surface.parabola
    (dx, dy), (mx, my), r = surface.direction[:2], surface.normal[:2], surface.pitch_radius
    start = surface.apex[0] + z * surface.trace[0]
    for _ in range(PASSES):
        turn = bend * s
        nx, ny = mx - turn * dx, my - turn * dy  # not of unit length; only their ratio counts
        slope = ny / nx
        x_c = start + s * (surface.along[0] + a * s * surface.out[0])
        x_s = surface.along[0] + turn * surface.out[0]
        y = slope * x_c
        y_s = bend * surface.twist / (nx * nx) * x_c + slope * x_s
        x = r + x_c
        step = 0.5 * (x * x + y * y - square) / (x * x_s + y * y_s)
        following = s - step
        s = np.minimum(np.maximum(following, low), high)
        if not (np.abs(step) > last)[s == following].any():
            break
    return np.where((np.abs(step) <= last) & (following >= low), following, np.nan)


def _fillet_profile(surface: Surface, square: FloatArray, z: FloatArray) -> FloatArray:
    """Solve by Newton inside a bracket from bottom land to joint; NaN outside."""
    low, high = np.full_like(z, surface.bottom), np.full_like(z, surface.joint)
    floor, top = cut_at(surface, low, z).square, cut_at(surface, high, z).square
    share = (square - floor) / (top - floor)
    slack = 1e-12
    s = surface.bottom + (surface.joint - surface.bottom) * np.sqrt(np.clip(share, 0.0, 1.0))
    for _ in range(FILLET_PASSES):
        cut = cut_at(surface, s, z)
        excess = cut.square - square
        above = excess > 0.0
        low, high = np.where(above, low, s), np.where(above, s, high)
        following = s - excess / cut.square_s
        following = np.where((following >= low) & (following <= high), following, 0.5 * (low + high))
        step, s = following - s, following
        if not (np.abs(step) > LAST_STEP * surface.scale).any():
            break
    return np.where((share >= -slack) & (share <= 1.0 + slack), s, np.nan)
