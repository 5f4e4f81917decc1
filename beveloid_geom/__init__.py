"""Tooth contact analysis of beveloid gears with generated, modified or measured flanks.

Functions, results and enumerations are imported when they are first used::

    inputs         Design of two Member (each with its Tool and Modification), a Pair and Errors, mm and rad,
                   or from_degrees; builtin_design, read_design, design_text; DesignError lists the faults
    layout         zero_backlash_layout, layout_deviation, design_remarks, layout_advice; propose for a
                   Request
    contact        path_of_contact returns a ContactPath with a Status for each position; contact_ratio,
                   contact_lines, path_sliding(path), path_pressure(path, Load(...))
    first contact  path_certificate(path), first_contact, mesh_cycle, pitch_cycle, operating_ratios,
                   contact_pattern, mounted_backlash
    analysis       ease_off, path_sensitivity, tolerance_study within Tolerances, design_map, place_path,
                   optimise_parabola and optimise_amounts for an Aim, fit_crowning, pattern_matrix
    workshop       tooth_data, ball_dimensions, span_measurement, measuring_grid, read_deviations, shim
    shapes         sample_flank, gear_solid, tooth_hexahedra; write(object, path)
    results        to_dict(result), to_csv(result)

The subpackages, ordered along the data flow, are `support`, `design`, `gear`, `pair`, `contact`, `operation`,
`analysis`, `workshop`, `shapes`, `export`, `validation`, `findings`, `proposal`, `report` and `cli`. Each
has a README.md.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__ as __version__

if TYPE_CHECKING:
    from .analysis.ease_off import EaseOff as EaseOff, SecondOrder as SecondOrder, ease_off as ease_off
    from .analysis.maps import DesignMap as DesignMap, design_map as design_map
    from .analysis.modification.amounts import (
        AmountsOptimum as AmountsOptimum,
        optimise_amounts as optimise_amounts,
    )
    from .analysis.modification.crowning import Crowning as Crowning, fit_crowning as fit_crowning
    from .analysis.mountings import Mountings as Mountings
    from .analysis.optimise import Aim as Aim, Optimum as Optimum, optimise_parabola as optimise_parabola
    from .analysis.path_placement import Placement as Placement, place_path as place_path
    from .analysis.pattern_matrix import PatternMatrix as PatternMatrix, pattern_matrix as pattern_matrix
    from .analysis.pressure import (
        Load as Load,
        PathPressure as PathPressure,
        path_pressure as path_pressure,
    )
    from .analysis.sensitivity import Sensitivity as Sensitivity, path_sensitivity as path_sensitivity
    from .analysis.sliding import Sliding as Sliding, path_sliding as path_sliding
    from .analysis.tolerance import (
        Tolerances as Tolerances,
        ToleranceStudy as ToleranceStudy,
        tolerance_study as tolerance_study,
    )
    from .contact.parallel.lines import ContactLines as ContactLines, contact_lines as contact_lines
    from .contact.path import (
        ContactPath as ContactPath,
        PathEnds as PathEnds,
        contact_ratio as contact_ratio,
        path_of_contact as path_of_contact,
    )
    from .design.deviations import FlankDeviations as FlankDeviations, mean_deviations as mean_deviations
    from .design.field_limits import DesignError as DesignError
    from .design.file import builtin_design as builtin_design
    from .design.member import Member as Member, Tool as Tool
    from .design.model import (
        Design as Design,
        Errors as Errors,
        MeshErrors as MeshErrors,
        Pair as Pair,
        from_degrees as from_degrees,
    )
    from .design.modification import Modification as Modification
    from .design.text import design_text as design_text
    from .export.write import write as write
    from .findings.advice import (
        Advice as Advice,
        design_remarks as design_remarks,
        layout_advice as layout_advice,
    )
    from .findings.diagnostics import Remark as Remark
    from .operation.backlash import Backlash as Backlash, mounted_backlash as mounted_backlash
    from .operation.certificate import Certificate as Certificate, path_certificate as path_certificate
    from .operation.contact_pattern.pattern import (
        ContactPattern as ContactPattern,
        MemberPattern as MemberPattern,
        contact_pattern as contact_pattern,
    )
    from .operation.first_contact import FirstContact as FirstContact, first_contact as first_contact
    from .operation.mesh_cycle import MeshCycle as MeshCycle, mesh_cycle as mesh_cycle
    from .operation.operating_ratio import (
        OperatingRatios as OperatingRatios,
        operating_ratios as operating_ratios,
    )
    from .operation.pitch_cycle import PitchCycle as PitchCycle, pitch_cycle as pitch_cycle
    from .pair.zero_backlash import (
        LayoutDeviation as LayoutDeviation,
        ZeroBacklashLayout as ZeroBacklashLayout,
        layout_deviation as layout_deviation,
        zero_backlash_layout as zero_backlash_layout,
    )
    from .proposal.propose import Proposal as Proposal, propose as propose
    from .proposal.request import Request as Request
    from .report.result import to_csv as to_csv, to_dict as to_dict
    from .shapes.hexahedra import tooth_hexahedra as tooth_hexahedra
    from .shapes.hexahedral_mesh import VolumeMesh as VolumeMesh
    from .shapes.sampling import FlankGrid as FlankGrid, sample_flank as sample_flank
    from .shapes.solid import Solid as Solid, gear_solid as gear_solid
    from .status import (
        BallStatus as BallStatus,
        EllipseStatus as EllipseStatus,
        FirstStatus as FirstStatus,
        Limit as Limit,
        NotComputed as NotComputed,
        PatternStatus as PatternStatus,
        PlaceStatus as PlaceStatus,
        RatioStatus as RatioStatus,
        ShimStatus as ShimStatus,
        SpanStatus as SpanStatus,
        Status as Status,
        Verdict as Verdict,
    )
    from .validation.statement_verdicts import Statement as Statement
    from .validation.statements import paper_statements as paper_statements
    from .workshop.balls import Balls as Balls, ball_dimensions as ball_dimensions
    from .workshop.design_file import read_design as read_design
    from .workshop.grid import MeasuringGrid as MeasuringGrid, measuring_grid as measuring_grid
    from .workshop.measured import Deviations as Deviations, read_deviations as read_deviations
    from .workshop.shim import Shim as Shim, shim as shim
    from .workshop.span import Span as Span, span_measurement as span_measurement
    from .workshop.tooth_data import ToothData as ToothData, tooth_data as tooth_data

_MODULE_OF = {
    name: module
    for module, names in {
        "analysis.ease_off": "EaseOff SecondOrder ease_off",
        "analysis.maps": "DesignMap design_map",
        "analysis.modification.amounts": "AmountsOptimum optimise_amounts",
        "analysis.modification.crowning": "Crowning fit_crowning",
        "analysis.optimise": "Aim Optimum optimise_parabola",
        "analysis.path_placement": "Placement place_path",
        "analysis.pattern_matrix": "PatternMatrix pattern_matrix",
        "analysis.pressure": "Load PathPressure path_pressure",
        "analysis.sensitivity": "Sensitivity path_sensitivity",
        "analysis.sliding": "Sliding path_sliding",
        "analysis.mountings": "Mountings",
        "analysis.tolerance": "ToleranceStudy Tolerances tolerance_study",
        "contact.parallel.lines": "ContactLines contact_lines",
        "contact.path": "ContactPath PathEnds contact_ratio path_of_contact",
        "design.deviations": "FlankDeviations mean_deviations",
        "design.field_limits": "DesignError",
        "design.file": "builtin_design",
        "design.member": "Member Tool",
        "design.model": "Design Errors MeshErrors Pair from_degrees",
        "design.modification": "Modification",
        "design.text": "design_text",
        "export.write": "write",
        "findings.advice": "Advice layout_advice design_remarks",
        "findings.diagnostics": "Remark",
        "operation.backlash": "Backlash mounted_backlash",
        "operation.certificate": "Certificate path_certificate",
        "operation.contact_pattern.pattern": "ContactPattern MemberPattern contact_pattern",
        "operation.first_contact": "FirstContact first_contact",
        "operation.mesh_cycle": "MeshCycle mesh_cycle",
        "operation.operating_ratio": "OperatingRatios operating_ratios",
        "operation.pitch_cycle": "PitchCycle pitch_cycle",
        "pair.zero_backlash": "ZeroBacklashLayout LayoutDeviation layout_deviation zero_backlash_layout",
        "proposal.propose": "Proposal propose",
        "proposal.request": "Request",
        "report.result": "to_csv to_dict",
        "shapes.hexahedra": "tooth_hexahedra",
        "shapes.hexahedral_mesh": "VolumeMesh",
        "shapes.sampling": "FlankGrid sample_flank",
        "shapes.solid": "Solid gear_solid",
        "status": "BallStatus EllipseStatus FirstStatus Limit NotComputed PatternStatus "
        "PlaceStatus RatioStatus ShimStatus SpanStatus Status Verdict",
        "validation.statement_verdicts": "Statement",
        "validation.statements": "paper_statements",
        "workshop.balls": "Balls ball_dimensions",
        "workshop.design_file": "read_design",
        "workshop.grid": "MeasuringGrid measuring_grid",
        "workshop.measured": "Deviations read_deviations",
        "workshop.shim": "Shim shim",
        "workshop.span": "Span span_measurement",
        "workshop.tooth_data": "ToothData tooth_data",
    }.items()
    for name in names.split()
}
"""Module by public name."""
_SUBPACKAGES = (
    "support design gear pair contact operation analysis workshop shapes export validation findings proposal"
    " report cli"
)
__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    """Import a public name or a subpackage when it is first used."""
    if name in _SUBPACKAGES.split():
        return import_module(f".{name}", __name__)
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted((*__all__, *_SUBPACKAGES.split(), "__version__"))
