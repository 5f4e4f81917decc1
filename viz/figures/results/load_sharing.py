"""Load sharing and transmission error of the pair under a torque, as a finite element program found them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design, first_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.placing import meshing_pair
from beveloid_geom.export.fea.pair_results import PairResult, read_pair_result
from beveloid_geom.pair.mounting import mounting_of

from ...parts.motion_graph import MICRO
from ...parts.recipe import Drawing, Recipe, Rows, Table, stacked
from ...stage import theme
from ...stage.layout import Cells

CELLS = Cells(left=0.85, right=0.85, across=1.75, down=1.35, most=2, least=5.0)
SAME = 1e-9
"""rad by which the gear's roll in a deck may differ from the first contact of the design."""
STEPS = 201
"""Rolls at which the rigid pair is drawn."""
NOTE = (
    "(a) The share of the pinion's torque that one tooth pair carries while it passes through the mesh, a"
    " mark for each tooth pair of each deck; dashed where the rigid flanks come into and go out of contact."
    " (b) The transmission error, gear roll plus N1/N2 pinion roll, of rigid teeth, whichever touches"
    " first, and under the load, each less its own mean; the elastic turn of the pinion times N1/N2 is in it."
)


@dataclass(frozen=True, eq=False)
class Loaded:
    """Results by roll (n,) of a design under one torque; `middle` and `ends` (2,): pinion rolls of its path
    of contact, rad; `rigid` (STEPS,): transmission error, rad, of rigid teeth at `rolls` of the pinion, and
    `unloaded` (n,) at those of the decks."""

    design: Design
    results: tuple[PairResult, ...]
    middle: float
    ends: FloatArray
    rolls: FloatArray
    rigid: FloatArray
    unloaded: FloatArray

    @property
    def pitch(self) -> float:
        """Of the pinion, rad."""
        return float(2.0 * np.pi / self.design.pinion.teeth)

    @property
    def ratio(self) -> float:
        """N1 / N2."""
        return float(self.design.pinion.teeth / self.design.gear.teeth)

    @property
    def turns(self) -> FloatArray:
        """How far the pinion turns on under load (n,), rad, with the sign of its roll."""
        turns = np.array([one.turn for one in self.results])
        return turns if self.results[0].flank == "right" else -turns

    @property
    def loaded_rolls(self) -> FloatArray:
        """Rolls (n,) of the pinion under load, rad."""
        return np.array([one.rolls[0] for one in self.results]) + self.turns

    @property
    def loaded(self) -> FloatArray:
        """Transmission error (n,) under load, rad."""
        return np.asarray(self.unloaded + self.ratio * self.turns)

    def pitches(self, rolls: FloatArray) -> FloatArray:
        """Give rolls in pitches from the middle of the path."""
        return np.asarray((rolls - self.middle) / self.pitch)

    @property
    def shares(self) -> tuple[FloatArray, FloatArray]:
        """Give pitches (m,) of tooth pairs from the middle, in order, and the share (m,) of each there."""
        pairs = np.arange(len(self.results[0].share)) - len(self.results[0].share) // 2
        at = self.pitches(np.array([one.rolls[0] for one in self.results]))[:, None] + pairs
        share = np.array([one.share for one in self.results])
        order = np.argsort(at.ravel())
        return at.ravel()[order], share.ravel()[order]


def decks_of(path: Path) -> list[Path]:
    """Find the deck of that name, or those that `mesh --part pair --rolls` wrote for this `--out`. Raises
    ValueError where there are both."""
    several = [
        one
        for one in sorted(path.parent.glob(f"{path.stem}-*{path.suffix}"))
        if one.stem[len(path.stem) + 1 :].isdigit()
    ]
    if several and path.exists():
        raise ValueError(f"there are both {path} and {several[0]}: remove what is not meant")
    return several or [path]


def loaded_pair(design: Design, path: Path) -> Loaded:
    """Read the results of the decks of a design. Raises ValueError for decks of another design, of several
    torques, flanks or numbers of teeth, for more or fewer than were written together, and as
    `read_pair_result`; OSError where one cannot be read."""
    decks = decks_of(path)
    results = sorted((read_pair_result(deck) for deck in decks), key=lambda one: float(one.rolls[0]))
    counts = sorted({one.decks for one in results})
    if decks != [path] and counts != [len(decks)]:
        several = f"{len(decks)} decks of {path}, written by --rolls {' and '.join(map(str, counts))}"
        raise ValueError(f"there are {several}: remove all and write them anew")
    if len({(one.flank, one.torque, len(one.force)) for one in results}) > 1:
        raise ValueError(
            f"the decks of {path} differ in flank, torque or teeth: write them anew with --rolls"
        )
    flank, own = results[0].flank, np.array([one.rolls for one in results])
    first = first_contact(design, flank, own[:, 0])
    if not np.abs(first.gear_roll - own[:, 1]).max() <= SAME:
        raise ValueError(f"the decks of {path} are not of this design: give theirs with --design")
    pose = meshing_pair(design, flank)
    half = np.pi / float(design.pinion.teeth)
    middle, low, high = float(pose.roll[0]), float(own[:, 0].min()), float(own[:, 0].max())
    rolls = np.linspace(min(low, middle - half), max(high, middle + half), STEPS)
    rigid = first_contact(design, flank, rolls).transmission_error
    ends = np.sort(pose.path.pinion_roll[[0, -1]])
    return Loaded(design, tuple(results), middle, ends, rolls, rigid, first.transmission_error)


def compute(found: Loaded) -> Loaded:
    """Give what was read and found already."""
    return found


def draw(found: Loaded, layout: theme.Layout) -> Drawing:
    """Draw load sharing and transmission error beside each other."""
    one, count = found.results[0], len(found.results)
    rolls = "one roll" if count == 1 else f"{count} rolls"
    page, low, high = theme.new_page(
        layout,
        "Load sharing and transmission error under load",
        f"{one.torque / 1e3:.4g} N m on the pinion, {one.flank} flanks; {rolls}, solved by CalculiX",
        NOTE,
        below=0.75,
        above=0.75,
        tall=CELLS.tall(layout, 2, 4.6),
    )
    shares, errors = theme.panels(page, CELLS, 2, low, high)
    _shares(shares, found)
    _errors(errors, found)
    return Drawing(page, {})


def _shares(axes: Axes, found: Loaded) -> None:
    at, share = found.shares
    axes.set_title("(a)  Share of one tooth pair", loc="left", pad=8.0, fontsize=theme.LABEL)
    axes.plot(at, 100.0 * share, "-o", color=theme.BLUE, ms=5.0, lw=1.6)
    for end in found.pitches(found.ends):
        axes.axvline(end, color=theme.GREY, linestyle="--", linewidth=1.2)
    axes.set(
        ylim=(-4.0, 106.0),
        xlabel="pinion roll before the load, from mid-path (pitches)",
        ylabel="share of torque (%)",
    )
    axes.grid(True)


def _errors(axes: Axes, found: Loaded) -> None:
    known = found.rigid[np.isfinite(found.rigid)]
    rigid, loaded = MICRO * (found.rigid - known.mean()), MICRO * (found.loaded - found.loaded.mean())
    axes.set_title("(b)  Transmission error", loc="left", pad=8.0, fontsize=theme.LABEL)
    axes.plot(found.pitches(found.rolls), rigid, color=theme.GREY, lw=1.6, label=f"rigid, {_swing(rigid)}")
    at = found.pitches(found.loaded_rolls)
    later = f"{MICRO * float(np.mean(found.ratio * found.turns)):.3g} \u00b5rad more in the mean"
    label = f"loaded, {_swing(loaded)}\n({later})"
    axes.plot(at, loaded, "-o", color=theme.BLUE, ms=5.0, lw=1.6, label=label)
    low, high = axes.get_ylim()
    room = max(high - low, 1e-3)
    radius = 1e-3 * float(mounting_of(found.design).working_radius[1])  # um for a urad
    axes.set(ylim=(low, low + 1.4 * room), xlabel="pinion roll, loaded or rigid, from mid-path (pitches)")
    axes.set_ylabel("error less its mean (\u00b5rad)")
    axes.grid(True)
    axes.legend(loc="upper left")
    beside = axes.twinx()
    beside.set(ylim=[radius * limit for limit in axes.get_ylim()])
    beside.set_ylabel("at the gear's pitch circle (\u00b5m)")


def _swing(error: FloatArray) -> str:
    """Say how far an error swings, urad."""
    return f"peak to peak {np.nanmax(error) - np.nanmin(error):.3g} \u00b5rad"


def rows(found: Loaded) -> Table:
    """List tooth pairs and errors by roll, in `pitches` from the middle of the path, too: those of a tooth
    pair without load; forces and where they act in S_f; then rigid teeth, and the ends of their path."""
    header = (
        "kind",
        "pinion_roll_rad",
        "pitches",
        "error_rad",
        "tooth_pair",
        "tooth_pair_pitches",
        "share",
        "force_N",
        "x_mm",
        "y_mm",
        "z_mm",
    )

    def cases() -> Rows:
        """Give the columns of every roll."""
        for one, roll, error in zip(found.results, found.loaded_rolls, found.loaded, strict=True):
            pairs = np.arange(len(one.share)) - len(one.share) // 2
            force = np.linalg.norm(one.force, axis=1)
            at, before = float(found.pitches(roll)), found.pitches(one.rolls[0]) + pairs
            yield "loaded", float(roll), at, float(error), pairs, before, one.share, force, *one.centre.T
        yield "rigid", found.rolls, found.pitches(found.rolls), found.rigid, *[""] * (len(header) - 4)
        yield "end of path", found.ends, found.pitches(found.ends), *[""] * (len(header) - 3)

    return header, stacked(cases())


RECIPES = {"load-sharing": Recipe(compute, draw, rows)}
