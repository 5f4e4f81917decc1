"""The figures of Ni et al. 2017, and what meshes add to them: their names, titles, and where each is drawn.

Every module `fig_*` has a dictionary `RECIPES` with a `Recipe` for each figure it draws. They
are imported when asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..parts.recipe import Recipe


@dataclass(frozen=True)
class Figure:
    """Name, as in `render-figures --only fig-07`, title, and module of a figure; whether it shows one flank,
    right unless told otherwise (`of_flank`), or how long something took (`timed`), so that nothing else
    should run."""

    name: str
    title: str
    module: str
    of_flank: bool = False
    timed: bool = False

    @property
    def set(self) -> str:
        """The room it is in: `paper`, `results` or `methods`."""
        return self.module.partition(".")[0]

    def recipe(self) -> Recipe[Any]:
        """Say how it is computed and drawn."""
        recipes: dict[str, Recipe[Any]] = import_module(f".{self.module}", __name__).RECIPES
        return recipes[self.name]


FIGURES = (
    Figure("fig-01", "The crossed beveloid gear pair", "paper.fig_01_pair", of_flank=True),
    Figure("fig-02", "Normal section of the rack cutter", "paper.fig_02_rack"),
    Figure("fig-03", "Frames of the generation", "paper.fig_03_generation"),
    Figure("fig-04", "Meshing model of the pair", "paper.fig_04_meshing"),
    Figure("fig-05", "Assembly errors", "paper.fig_05_errors"),
    Figure("fig-06", "Effect of the parabola coefficient's sign on the flank", "paper.fig_06_modification"),
    Figure(
        "fig-07", "Paths of contact, both coefficients positive", "paper.fig_07_to_10_paths", of_flank=True
    ),
    Figure(
        "fig-08", "Paths of contact, both coefficients negative", "paper.fig_07_to_10_paths", of_flank=True
    ),
    Figure(
        "fig-09",
        "Paths of contact, pinion positive and gear negative",
        "paper.fig_07_to_10_paths",
        of_flank=True,
    ),
    Figure(
        "fig-10",
        "Paths of contact, pinion negative and gear positive",
        "paper.fig_07_to_10_paths",
        of_flank=True,
    ),
    Figure("fig-11", "Contact ratio against the coefficient", "paper.fig_11_contact_ratio"),
    Figure("fig-12", "Paths of contact under offset error", "paper.fig_12_to_15_misalignment", of_flank=True),
    Figure(
        "fig-13", "Paths of contact under shaft-angle error", "paper.fig_12_to_15_misalignment", of_flank=True
    ),
    Figure(
        "fig-14",
        "Paths of contact under axial error of the pinion",
        "paper.fig_12_to_15_misalignment",
        of_flank=True,
    ),
    Figure(
        "fig-15",
        "Paths of contact under axial error of the gear",
        "paper.fig_12_to_15_misalignment",
        of_flank=True,
    ),
    Figure("separation", "Separation of the flanks at one position", "results.pattern", of_flank=True),
    Figure("pattern", "Contact pattern under marking compound", "results.pattern"),
    Figure("pattern-errors", "Contact pattern under two errors", "results.pattern_errors"),
    Figure(
        "transmission-error",
        "Motion graph: transmission error of every tooth pair, and of the one that runs",
        "results.transmission_error",
        of_flank=True,
    ),
    Figure("statements", "The paper's sixteen statements, judged", "results.statements"),
    Figure("ease-off", "Ease-off of the pinion's flanks", "results.ease_off"),
    Figure("sliding", "Sliding speed and specific sliding along the path of contact", "results.sliding"),
    Figure("sensitivity", "Sensitivity of the path of contact to assembly errors", "results.sensitivity"),
    Figure("tolerance-cloud", "Paths of contact under drawn assembly errors", "results.tolerance_cloud"),
    Figure("map-parabola", "Map of a design over its parabola coefficients", "results.maps", of_flank=True),
    Figure("map-mounting", "Map of a design over its mounting distances", "results.maps", of_flank=True),
    Figure("posed-pair", "The posed pair as exported", "results.posed_pair", of_flank=True),
    Figure("meshed-tooth", "A tooth meshed for finite elements", "results.meshed_tooth"),
    Figure(
        "mesh-convergence", "Error of the mesh method against the mesh tolerance", "methods.mesh_convergence"
    ),
    Figure(
        "speed-accuracy",
        "Speed against accuracy of every way to find the contact",
        "methods.speed_accuracy",
        timed=True,
    ),
)
MEASURED = Figure("deviations", "Deviations of measured points from the flanks", "results.deviations")
LOADED = Figure("load-sharing", "Load sharing and transmission error under load", "results.load_sharing")
"""Drawn of a file of measured points, and of solved decks of the pair in contact; in no set."""
SETS = ("paper", "results", "methods")
UNASKED = ("paper", "results")
"""Sets of figures, and those that are drawn where none is asked for: not what tells of the methods alone."""
