"""Load sharing and transmission error of the pair under a torque, from finite element results."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from beveloid_geom import Design, first_contact
from beveloid_geom.arrays import FloatArray, gear_sense
from beveloid_geom.contact.mesh_position import frames_at, meshing_pair
from beveloid_geom.export.fea.pair_results import PairResult, read_pair_result
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.columns import ARCSEC

from ...components.charts import ZERO_ERROR_ARCSEC
from ...components.figure_steps import Drawing, Recipe, Rows, Table, rows_of_cases
from ...rendering import theme
from ...rendering.layout import PanelRows


@dataclass(frozen=True, eq=False)
class Loaded:
    """Results by roll (n,) of a design under one torque.

    `middle`, `ends` (2,): pinion rolls at the middle and at the ends of the path, rad. `rigid` (m,):
    transmission error of rigid teeth, rad, at the pinion rolls `rolls` (m,); `unloaded` (n,): the same at the
    rolls of the decks. Deck: input file of CalculiX for one roll."""

    design: Design
    results: tuple[PairResult, ...]
    middle: float
    ends: FloatArray
    rolls: FloatArray
    rigid: FloatArray
    unloaded: FloatArray

    @property
    def pitch(self) -> float:
        """Angular pitch of the pinion, rad."""
        return float(2.0 * np.pi / self.design.pinion.teeth)

    @property
    def turns(self) -> FloatArray:
        """Rotation of the pinion due to the load (n,), rad, with the sign of its roll."""
        turns = np.array([one.turn for one in self.results])
        return turns if self.results[0].flank == "right" else -turns

    @property
    def loaded_rolls(self) -> FloatArray:
        """Rolls of the pinion under load (n,), rad."""
        return np.array([one.rolls[0] for one in self.results]) + self.turns

    @property
    def loaded(self) -> FloatArray:
        """Transmission error (n,) under load, rad."""
        sense = gear_sense(self.results[0].flank)
        speed_ratio = float(self.design.pinion.teeth / self.design.gear.teeth)  # N1/N2
        return np.asarray(self.unloaded + sense * speed_ratio * self.turns)

    def pitches(self, rolls: FloatArray) -> FloatArray:
        """Return rolls in pitches from the middle of the path."""
        return np.asarray((rolls - self.middle) / self.pitch)

    @property
    def shares(self) -> tuple[FloatArray, FloatArray]:
        """Return pitches (m,) of tooth pairs from the middle, sorted, and the share of the torque (m,) of
        each."""
        pairs = np.arange(len(self.results[0].share)) - len(self.results[0].share) // 2
        at = self.pitches(np.array([one.rolls[0] for one in self.results]))[:, None] + pairs
        share = np.array([one.share for one in self.results])
        order = np.argsort(at.ravel())
        return at.ravel()[order], share.ravel()[order]


def decks_of(path: Path) -> list[Path]:
    """Return the deck of that name, or those that `mesh --part pair --rolls` wrote for this `--out`.

    Raises ValueError if both exist."""
    several = [
        one
        for one in sorted(path.parent.glob(f"{path.stem}-*{path.suffix}"))
        if one.stem[len(path.stem) + 1 :].isdigit()
    ]
    if several and path.exists():
        raise ValueError(f"there are both {path} and {several[0]}: remove the unwanted files")
    return several or [path]


def _named_design(deck: Path) -> str:
    """Return the name of the design in the header of a deck, '' if there is none."""
    with open(deck, encoding="ascii", errors="replace") as file:
        match = re.search(r"^\*\* pair of (.*), \d+ (?:tooth|teeth) of each$", file.read(2000), re.MULTILINE)
    return match[1] if match else ""


def loaded_pair(design: Design, path: Path, name: str = "") -> Loaded:
    """Read the results of the decks of a design with a `name`, which is compared with the name in the decks
    if both are known.

    Raises ValueError for decks of another design, of several torques, flanks or numbers of teeth, for an
    incomplete set, and as `read_pair_result`; OSError if a file cannot be read."""
    # Tolerances for a deck that belongs to a design: gear roll against the first contact (rad), and
    # position of the mid-faces relative to their largest coordinate in S_f.
    deck_tolerance = 1e-9
    decks = decks_of(path)
    results = sorted((read_pair_result(deck) for deck in decks), key=lambda one: float(one.rolls[0]))
    counts = sorted({one.decks for one in results})
    if decks != [path] and counts != [len(decks)]:
        several = f"{len(decks)} decks of {path}, written by --rolls {' and '.join(map(str, counts))}"
        raise ValueError(f"there are {several}: remove them all and write them again")
    if len({(one.flank, one.torque, len(one.force)) for one in results}) > 1:
        raise ValueError(
            f"the decks of {path} differ in flank, torque or teeth: write them again with --rolls"
        )
    written = name.encode("ascii", "replace").decode()  # as in decks
    for other in filter(None, map(_named_design, decks)):
        if written and Path(other).stem != Path(written).stem:
            raise ValueError(f"the decks of {path} belong to {other}, not to {name}: name it with --design")
    flank, rolls_of_decks = results[0].flank, np.array([one.rolls for one in results])
    # Rolls do not depend on the size of the gears, so the positions of the members are compared as well.
    origins = np.array([origin for _, origin in frames_at(design, *rolls_of_decks[0])])
    apart, size = np.abs(results[0].origins - origins).max(), np.abs(origins).max()
    if not apart <= deck_tolerance * size:
        raise ValueError(
            f"the decks of {path} belong to another design: name it with --design (the mid-faces"
            f" differ by {apart:.4g} mm)"
        )
    first = first_contact(design, flank, rolls_of_decks[:, 0])
    if not np.abs(first.gear_roll - rolls_of_decks[:, 1]).max() <= deck_tolerance:
        raise ValueError(f"the decks of {path} belong to another design: name it with --design")
    pose = meshing_pair(design, flank)
    half = np.pi / float(design.pinion.teeth)
    middle, loaded = float(pose.roll[0]), rolls_of_decks[:, 0]
    low, high = float(loaded.min()), float(loaded.max())
    rolls = np.linspace(min(low, middle - half), max(high, middle + half), 201)
    rigid = first_contact(design, flank, rolls).transmission_error
    ends = np.sort(pose.path.pinion_roll[[0, -1]])
    return Loaded(design, tuple(results), middle, ends, rolls, rigid, first.transmission_error)


def compute(loaded: Loaded) -> Loaded:
    """Return the results, which are computed when the files are read."""
    return loaded


def draw(result: Loaded, layout: theme.PageLayout) -> Drawing:
    """Draw load sharing and transmission error."""
    cells = PanelRows(left=1.05, right=1.15, across=1.75, down=1.35, most=2, least=5.0)
    one, count = result.results[0], len(result.results)
    rolls = "one roll" if count == 1 else f"{count} rolls"
    page, low, high = theme.new_page(
        layout,
        "Load sharing and transmission error under load",
        f"{one.torque / 1e3:.4g} N m on the pinion, {one.flank} flanks; {rolls}, solved by CalculiX",
        (
            "(a) Fraction of the pinion torque on one tooth pair during its mesh; a mark for each tooth pair"
            " at each roll; dashed: start and end of contact of rigid flanks. (b) Positive: gear ahead; the"
            " mean of each curve is subtracted. Loaded: the gear also lags by N1/N2 (tooth numbers) times the"
            " elastic rotation of the pinion."
        ),
        below=0.75,
        above=0.75,
        tall=cells.tall(layout, 2, 4.6),
    )
    shares, errors = theme.panels(page, cells, 2, low, high)
    _shares(shares, result)
    _errors(errors, result)
    return Drawing(page, {})


def _shares(axes: Axes, loaded: Loaded) -> None:
    at, share = loaded.shares
    axes.set_title("(a)  Share of one tooth pair", loc="left", pad=8.0, fontsize=theme.LABEL)
    axes.plot(at, 100.0 * share, "-o", color=theme.BLUE, ms=5.0, lw=1.6)
    for end in loaded.pitches(loaded.ends):
        axes.axvline(end, color=theme.GREY, linestyle="--", linewidth=1.2)
    axes.set(
        ylim=(-4.0, 106.0),
        xlabel="pinion roll before the load, from mid-path (pitches)",
        ylabel="share of torque (%)",
    )
    axes.grid(True)


def _errors(axes: Axes, result: Loaded) -> None:
    known = result.rigid[np.isfinite(result.rigid)]
    rigid, loaded = ARCSEC * (result.rigid - known.mean()), ARCSEC * (result.loaded - result.loaded.mean())
    axes.set_title("(b)  Transmission error", loc="left", pad=8.0, fontsize=theme.LABEL)
    axes.plot(result.pitches(result.rolls), rigid, color=theme.GREY, lw=1.6, label=f"rigid, {_swing(rigid)}")
    at = result.pitches(result.loaded_rolls)
    behind = ARCSEC * float(np.mean(result.unloaded - result.loaded))
    label = f"loaded, {_swing(loaded)}\n({behind:.3g} arcsec behind in the mean)"
    if loaded.size == 1:
        label = f"loaded, one roll: {behind:.3g} arcsec behind"
    axes.plot(at, loaded, "-o", color=theme.BLUE, ms=5.0, lw=1.6, label=label)
    low, high = axes.get_ylim()
    span = max(high - low, 1e-3)
    radius = 1e3 / ARCSEC * float(mounting_of(result.design).working_radius[1])  # um per arcsec
    axes.set(ylim=(low, low + 1.4 * span), xlabel="pinion roll, loaded or rigid, from mid-path (pitches)")
    axes.set_ylabel("gear ahead of its mean (arcsec)")
    axes.grid(True)
    axes.legend(loc="upper left", fontsize=theme.SMALL)
    length_axes = axes.twinx()
    length_axes.set(ylim=[radius * limit for limit in axes.get_ylim()])
    length_axes.set_ylabel("at the gear's pitch circle (\u00b5m)")


def _swing(error: FloatArray) -> str:
    """Return the peak-to-peak value of an error, arcsec, as text."""
    swing = float(np.nanmax(error) - np.nanmin(error))
    return f"peak to peak {swing:.3g} arcsec" if swing > ZERO_ERROR_ARCSEC else "zero within rounding"


def rows(loaded: Loaded) -> Table:
    """List tooth pairs and errors by roll, also in `pitches` from the middle of the path.

    Pitches of a tooth pair are those without load. Forces act at their points in S_f. Rigid teeth and the
    ends of the path follow."""
    of_pair = ("tooth_pair", "tooth_pair_pitches", "share", "force_N", "x_mm", "y_mm", "z_mm")
    header = ("kind", "pinion_roll_rad", "pitches", "error_rad", *of_pair)

    def cases() -> Rows:
        """Yield the columns of every roll."""
        for one, roll, error in zip(loaded.results, loaded.loaded_rolls, loaded.loaded, strict=True):
            pairs = np.arange(len(one.share)) - len(one.share) // 2
            force = np.linalg.norm(one.force, axis=1)
            at, before = float(loaded.pitches(roll)), loaded.pitches(one.rolls[0]) + pairs
            yield "loaded", float(roll), at, float(error), pairs, before, one.share, force, *one.centre.T
        nothing = [""] * len(of_pair)
        yield "rigid", loaded.rolls, loaded.pitches(loaded.rolls), loaded.rigid, *nothing
        yield "end of path", loaded.ends, loaded.pitches(loaded.ends), "", *nothing

    return header, rows_of_cases(cases())


RECIPES = {"load-sharing": Recipe(compute, draw, rows)}
