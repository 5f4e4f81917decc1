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


TITLES = {
    "paper.fig_01_pair": {"fig-01": "The crossed beveloid gear pair"},
    "paper.fig_02_rack": {"fig-02": "Normal section of the rack cutter"},
    "paper.fig_03_generation": {"fig-03": "Frames of the generation"},
    "paper.fig_04_meshing": {"fig-04": "Meshing model of the pair"},
    "paper.fig_05_errors": {"fig-05": "Assembly errors"},
    "paper.fig_06_modification": {"fig-06": "Effect of the parabola coefficient's sign on the flank"},
    "paper.fig_07_to_10_paths": {
        "fig-07": "Paths of contact, both coefficients positive",
        "fig-08": "Paths of contact, both coefficients negative",
        "fig-09": "Paths of contact, pinion positive and gear negative",
        "fig-10": "Paths of contact, pinion negative and gear positive",
    },
    "paper.fig_11_contact_ratio": {"fig-11": "Contact ratio against the coefficient"},
    "paper.fig_12_to_15_misalignment": {
        "fig-12": "Paths of contact under offset error",
        "fig-13": "Paths of contact under shaft-angle error",
        "fig-14": "Paths of contact under axial error of the pinion",
        "fig-15": "Paths of contact under axial error of the gear",
    },
    "results.method": {"method": "Contact point by coarse meshes, and refined on the exact flanks"},
    "results.pattern": {
        "separation": "Separation of the flanks at one position",
        "pattern": "Contact pattern under marking compound",
    },
    "results.pattern_errors": {"pattern-errors": "Contact pattern under two errors"},
    "results.transmission_error": {
        "transmission-error": "Motion graph: transmission error of every tooth pair, and of the pair in"
        " contact"
    },
    "results.modifications": {"modifications": "Modified or measured flanks compared"},
    "results.ease_off": {"ease-off": "Ease-off of the pinion's flanks"},
    "results.sliding": {"sliding": "Sliding speed and specific sliding along the path of contact"},
    "results.sensitivity": {"sensitivity": "Sensitivity of the path of contact to assembly errors"},
    "results.tolerance_cloud": {"tolerance-cloud": "Paths of contact under random assembly errors"},
    "results.parabola_map": {"map-parabola": "Map over sum and difference of the parabola coefficients"},
    "results.posed_pair": {"posed-pair": "The pair in mesh as exported"},
    "results.meshed_tooth": {"meshed-tooth": "A tooth meshed for finite elements"},
    "methods.mesh_convergence": {"mesh-convergence": "Error of the mesh method against the mesh tolerance"},
    "methods.stability": {
        "stability": "Where methods fail: near the smallest shaft angle with a common normal"
    },
    "methods.speed_accuracy": {"speed-accuracy": "Error and time of five methods that find the contact"},
}
"""Titles by module and name, in the order of the figures."""
OF_FLANK = {
    *("fig-01", "fig-06", "fig-07", "fig-08", "fig-09", "fig-10", "fig-12", "fig-13", "fig-14", "fig-15"),
    *("method", "separation", "transmission-error", "modifications", "tolerance-cloud", "map-parabola"),
    *("posed-pair", "stability", "speed-accuracy"),
}
"""Figures that show one flank."""
FLAT = {
    *("fig-02", "fig-11", "method", "pattern-errors", "transmission-error", "modifications", "ease-off"),
    *("sliding", "sensitivity", "map-parabola", "mesh-convergence", "stability", "speed-accuracy"),
}
"""Figures without 3D pictures."""
FIGURES = tuple(
    Figure(name, title, module, name in OF_FLANK, name == "speed-accuracy", name in FLAT)
    for module, titles in TITLES.items()
    for name, title in titles.items()
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
