"""Figures: names, titles, and the modules that draw them.

Every module has a dictionary `RECIPES` with a `Recipe` for each of its figures. Modules are imported when a
figure is requested."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..components.figure_steps import Recipe


@dataclass(frozen=True)
class Figure:
    """A figure.

    Attributes: `name`, as in `render-figures --only fig-07`; `title`; `module`. `of_flank`: the figure shows
    one flank, the right one by default. `timed`: the figure measures times, so that nothing else may run.
    `flat`: the figure has no 3D pictures and does not need OpenGL."""

    name: str
    title: str
    module: str
    of_flank: bool = False
    timed: bool = False
    flat: bool = False

    @property
    def set(self) -> str:
        """Set of the figure: `paper`, `results` or `methods`."""
        return self.module.partition(".")[0]

    def recipe(self) -> Recipe[Any]:
        """Return the functions that compute and draw the figure."""
        recipes: dict[str, Recipe[Any]] = import_module(f".{self.module}", __name__).RECIPES
        return recipes[self.name]


FIGURES = (
    Figure("fig-01", "The crossed beveloid gear pair", "paper.fig_01_pair", of_flank=True),
    Figure("fig-02", "Normal section of the rack cutter", "paper.fig_02_rack", flat=True),
    Figure("fig-03", "Frames of the generation", "paper.fig_03_generation"),
    Figure("fig-04", "Meshing model of the pair", "paper.fig_04_meshing"),
    Figure("fig-05", "Assembly errors", "paper.fig_05_errors"),
    Figure(
        "fig-06",
        "Effect of the parabola coefficient's sign on the flank",
        "paper.fig_06_modification",
        of_flank=True,
    ),
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
    Figure("fig-11", "Contact ratio against the coefficient", "paper.fig_11_contact_ratio", flat=True),
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
    Figure(
        "method",
        "Contact point by coarse meshes, and refined on the exact flanks",
        "results.method",
        of_flank=True,
        flat=True,
    ),
    Figure("separation", "Separation of the flanks at one position", "results.pattern", of_flank=True),
    Figure("pattern", "Contact pattern under marking compound", "results.pattern"),
    Figure("pattern-errors", "Contact pattern under two errors", "results.pattern_errors", flat=True),
    Figure(
        "transmission-error",
        "Motion graph: transmission error of every tooth pair, and of the pair in contact",
        "results.transmission_error",
        of_flank=True,
        flat=True,
    ),
    Figure(
        "modifications",
        "Modified or measured flanks compared",
        "results.modifications",
        of_flank=True,
        flat=True,
    ),
    Figure("ease-off", "Ease-off of the pinion's flanks", "results.ease_off", flat=True),
    Figure(
        "sliding",
        "Sliding speed and specific sliding along the path of contact",
        "results.sliding",
        flat=True,
    ),
    Figure(
        "sensitivity",
        "Sensitivity of the path of contact to assembly errors",
        "results.sensitivity",
        flat=True,
    ),
    Figure(
        "tolerance-cloud",
        "Paths of contact under random assembly errors",
        "results.tolerance_cloud",
        of_flank=True,
    ),
    Figure(
        "map-parabola",
        "Map over sum and difference of the parabola coefficients",
        "results.parabola_map",
        of_flank=True,
        flat=True,
    ),
    Figure("posed-pair", "The pair in mesh as exported", "results.posed_pair", of_flank=True),
    Figure("meshed-tooth", "A tooth meshed for finite elements", "results.meshed_tooth"),
    Figure(
        "mesh-convergence",
        "Error of the mesh method against the mesh tolerance",
        "methods.mesh_convergence",
        flat=True,
    ),
    Figure(
        "stability",
        "Where methods fail: near the smallest shaft angle with a common normal",
        "methods.stability",
        of_flank=True,
        flat=True,
    ),
    Figure(
        "speed-accuracy",
        "Error and time of five methods that find the contact",
        "methods.speed_accuracy",
        of_flank=True,
        timed=True,
        flat=True,
    ),
)
MEASURED = Figure(
    "deviations", "Deviations of measured points from the flanks", "results.deviations", flat=True
)
LOADED = Figure(
    "load-sharing", "Load sharing and transmission error under load", "results.load_sharing", flat=True
)
"""Figures of measured points and of finite element results of the pair; they belong to no set."""
SETS = ("paper", "results", "methods")
"""All sets of figures."""
DEFAULT_SETS = ("paper", "results")
"""Sets that are drawn by default."""
