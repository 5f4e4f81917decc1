"""The figures of Ni et al. 2017, and what meshes add to them: their names, titles, and where each is drawn.

Every module `fig_*` has a dictionary `RECIPES` with a `Recipe` for each figure it draws. They
are imported when asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..recipe import Recipe


@dataclass(frozen=True)
class Figure:
    """Name, as in `render-figures --only fig-07`, title, and module of a figure."""

    name: str
    title: str
    module: str

    def recipe(self) -> Recipe[Any]:
        """How it is computed and drawn."""
        recipes: dict[str, Recipe[Any]] = import_module(f".{self.module}", __name__).RECIPES
        return recipes[self.name]


FIGURES = (
    Figure("fig-01", "The crossed beveloid gear pair", "fig_pair"),
    Figure("fig-02", "Normal section of the rack cutter", "fig_rack"),
    Figure("fig-03", "Frames of the generation", "fig_generation"),
    Figure("fig-04", "Meshing model of the pair", "fig_meshing"),
    Figure("fig-05", "Assembly errors", "fig_errors"),
    Figure("fig-06", "Effect of the parabola coefficient's sign on the flank", "fig_modification"),
    Figure("fig-07", "Paths of contact, both coefficients positive", "fig_paths"),
    Figure("fig-08", "Paths of contact, both coefficients negative", "fig_paths"),
    Figure("fig-09", "Paths of contact, pinion positive and gear negative", "fig_paths"),
    Figure("fig-10", "Paths of contact, pinion negative and gear positive", "fig_paths"),
    Figure("fig-11", "Contact ratio against the coefficient", "fig_contact_ratio"),
    Figure("fig-12", "Paths of contact under offset error", "fig_misalignment"),
    Figure("fig-13", "Paths of contact under shaft-angle error", "fig_misalignment"),
    Figure("fig-14", "Paths of contact under axial error of the pinion", "fig_misalignment"),
    Figure("fig-15", "Paths of contact under axial error of the gear", "fig_misalignment"),
    Figure("separation", "Separation of the flanks at one position", "fig_pattern"),
    Figure("pattern", "Contact pattern under marking compound", "fig_pattern"),
    Figure("transmission-error", "Transmission error in operation, and its amplitudes", "fig_operation"),
    Figure("sliding", "Sliding speed and specific sliding along the path of contact", "fig_sliding"),
    Figure("sensitivity", "Sensitivity of the path of contact to assembly errors", "fig_sensitivity"),
    Figure("tolerance-cloud", "Paths of contact under drawn assembly errors", "fig_cloud"),
    Figure("map-parabola", "Map of a design over its parabola coefficients", "fig_maps"),
    Figure("map-mounting", "Map of a design over its mounting distances", "fig_maps"),
    Figure("map-shift", "Map of a design over its profile shift coefficients", "fig_maps"),
    Figure("mesh-convergence", "Error of the mesh method against the mesh tolerance", "fig_convergence"),
    Figure("picture-density", "Where a finer mesh stops being seen", "fig_density"),
    Figure("speed-accuracy", "Speed against accuracy of every way to find the contact", "fig_speed"),
    Figure("job-size", "Time and memory against the size of the job", "fig_job_size"),
    Figure("posed-pair", "The posed pair as exported", "fig_posed"),
    Figure("meshed-tooth", "A tooth meshed for finite elements", "fig_meshed"),
)
