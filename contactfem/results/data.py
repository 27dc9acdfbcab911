"""Results of a run as frozen records in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from contactfem.common.typing import Floats, Ints
from contactfem.laws.active_set import Status as Status

if TYPE_CHECKING:
    from contactfem.case.schema import Case


@dataclass(frozen=True)
class HeatStep:
    """Heat in one accepted step, the same on all ranks.

    Attributes:
        passes: passes of mechanics and heat.
        change: change of temperature in the last pass over its range [-].
        temperature_min: smallest temperature at the end [K].
        temperature_max: largest one [K].
        stored: growth of the heat that the bodies hold [J/m].
        held: heat that came in where temperature is prescribed, per condition "body.surface" [J/m].
        loads: heat that sources, fluxes and convection brought [J/m].
        friction: frictional heat that entered the bodies [J/m].
        obstacles: heat conducted from obstacles [J/m].
        strained: heat that straining brought [J/m].
        defect: what is stored but came from nowhere [J/m].
        flow: conducted from nonmortar to mortar at the end, per interface [W/m].
        friction_defect: relative error of the interpolated frictional power before it was made
            that of mechanics, the largest of the interfaces [-].
        rings: what a time scheme does that rings, else empty.
        moved: heat that moved inside the bodies and across interfaces, either way [J/m].
        bounds: that temperatures cannot leave by the maximum principle, lower and upper [K]; None
            where a source, friction or straining lifts one.
        outside: how far they left them, over the range of temperatures [-].
    """

    passes: int
    change: float
    temperature_min: float
    temperature_max: float
    stored: float
    held: dict[str, float]
    loads: float
    friction: float
    obstacles: float
    strained: float
    defect: float
    flow: dict[str, float]
    friction_defect: float
    rings: str
    moved: float = 0.0
    bounds: tuple[float | None, float | None] = (None, None)
    outside: float = 0.0


@dataclass(frozen=True)
class Remeshing:
    """A new mesh of one body for one problem, "mechanics" or "heat"; t is the step's start [s].

    `eta` is the error of the problem on the meshes that were replaced.
    """

    t: float
    problem: str
    body: str
    cells_before: int
    cells_after: int
    reason: str
    seconds: float
    eta: float


@dataclass(frozen=True)
class Observables:
    """What is observed of a step as a whole, or how far that changed.

    Attributes:
        forces: of every interface on its mortar side [N/m].
        temperature_max: the hottest temperature [K]; None without heat.
        temperature_mean: the mean one, by heat capacity [K]; None where none is stored.
    """

    forces: dict[str, tuple[float, ...]]
    temperature_max: float | None
    temperature_mean: float | None

    def minus(self, before: Observables) -> Observables:
        """Change since something before."""
        return Observables(
            {
                name: (x - before.forces[name][0], y - before.forces[name][1])
                for name, (x, y) in self.forces.items()
            },
            _difference(self.temperature_max, before.temperature_max),
            _difference(self.temperature_mean, before.temperature_mean),
        )


def _difference(a: float | None, b: float | None) -> float | None:
    return None if a is None or b is None else a - b


@dataclass(frozen=True)
class ErrorStep:
    """Estimated errors of an accepted step and what was decided, the same on all ranks.

    Relative errors η are ratios of norms; `_printed` ones are the ratios of their squares that
    (40) is printed with. None where not estimated.

    Attributes:
        mechanics: η of the stress [-].
        mechanics_printed: its square [-].
        heat: η of the heat flux [-].
        heat_printed: its square [-].
        time: η of the rate of temperature [-].
        time_printed: its square [-].
        cells: of the mechanical meshes, by body.
        thermal_cells: of the thermal meshes, by body.
        remeshes: new meshes that were made for the step.
        repeats: how often it was taken again with a smaller length because of its error.
        decisions: in words, in order.
        change: what the step gives with its new meshes, less what it gave with those before; None
            without new ones, or if it became shorter after that.
    """

    mechanics: float | None
    mechanics_printed: float | None
    heat: float | None
    heat_printed: float | None
    time: float | None
    time_printed: float | None
    cells: dict[str, int]
    thermal_cells: dict[str, int]
    remeshes: tuple[Remeshing, ...]
    repeats: int
    decisions: tuple[str, ...]
    change: Observables | None = None


@dataclass(frozen=True)
class StepReport:
    """One accepted step, with scalars that are the same on all ranks.

    Attributes:
        step: number of the step, from 1.
        t: time at the end of the step [s].
        dt: length of the step [s].
        iterations: Newton iterations of the solve that was accepted.
        cutbacks: how often the step was halved before it was accepted.
        residuals: scaled residual norm before each iteration and after the last [-].
        open: nonmortar nodes without contact, over all interfaces.
        stick: nonmortar nodes that stick.
        slip: nonmortar nodes that slip (all active ones where there is no friction).
        forces: resultant (Fx, Fy) or (Fx, Fy, Fz) on the mortar side, per interface [N/m].
        dissipation: frictional work of the step [J/m].
        wall: wall-clock time of the step, failed attempts included [s].
        moment_defects: moment that the forces of both sides leave over, relative, per interface.
        heat: heat in the step; None where it is not solved for.
        errors: estimated errors; None without adaptivity.
    """

    step: int
    t: float
    dt: float
    iterations: int
    cutbacks: int
    residuals: tuple[float, ...]
    open: int
    stick: int
    slip: int
    forces: dict[str, tuple[float, ...]]
    dissipation: float
    wall: float
    moment_defects: dict[str, float] = field(default_factory=dict)
    heat: HeatStep | None = None
    errors: ErrorStep | None = None


@dataclass(frozen=True)
class Failure:
    """A step that failed.

    Attributes:
        t: time that it was to reach [s].
        reason: why it failed.
        dt: length of the step that was tried next [s].
    """

    t: float
    reason: str
    dt: float


class SurfaceHeat(NamedTuple):
    """Heat at the nonmortar nodes of an interface; not a number where nothing is opposite.

    ϑ_nm and ϑ_m [K], heat conducted from nonmortar to mortar q [W/m²], frictional heat d [W/m²],
    (n,) each.
    """

    temperature: Floats
    mortar_temperature: Floats
    flux: Floats
    dissipation: Floats


@dataclass(frozen=True)
class InterfaceTable:
    """State of one interface along its nonmortar surface, in the plane ordered by arc length.

    Attributes:
        name: name of the interface.
        X: reference positions (n, dim) [m].
        x: current positions (n, dim) [m].
        arc: arc length along the current surface (n,) [m]; zero in space.
        gap: mean gap around the node, open > 0, NaN where no mortar side is near (n,) [m].
        pressure: normal multiplier, compression > 0 (n,) [Pa].
        traction: tangential multiplier on the mortar side along (n_y, -n_x), in space its size
            (n,) [Pa].
        slip: accumulated slip of nonmortar relative to mortar, likewise (n,) [m].
        status: values of `Status` (n,).
        coverage: share of the node's facets that faces the mortar side (n,) [-].
        facet_length: half the length of the facets at the node, summed; in space the root of the
            area around it (n,) [m].
        depth: what a length of facet stands for (n,) [m]: 1, around an axis the circumference, in
            space the same length again.
        facets: nodes of the facets (k, nf).
        heat: heat at the nodes; None where it is not solved for.
        mortar_x: current positions of the mortar nodes (k, 2) [m]; empty for an obstacle.
        mortar_pressure: pressure seen from the mortar side (k,) [Pa].
        traction_vector: tangential multiplier in space (n, 3) [Pa]; None in the plane.
        slip_vector: accumulated slip in space (n, 3) [m]; None in the plane.
    """

    name: str
    X: Floats
    x: Floats
    arc: Floats
    gap: Floats
    pressure: Floats
    traction: Floats
    slip: Floats
    status: npt.NDArray[np.int8]
    coverage: Floats
    facet_length: Floats
    mortar_x: Floats
    mortar_pressure: Floats
    depth: Floats | float = 1.0
    facets: Ints = field(default_factory=lambda: np.empty((0, 2), np.int64))
    heat: SurfaceHeat | None = None
    traction_vector: Floats | None = None
    slip_vector: Floats | None = None


@dataclass(frozen=True)
class BodyPicture:
    """One body gathered on rank 0, for figures and extremes.

    Attributes:
        name: name of the body.
        points: reference positions (n, dim) [m].
        cells: vertices of the cells (m, nv), dolfinx order (tensor order of quadrilaterals).
        displacement: nodal displacement (n, dim) [m].
        fields: nodal fields; "stress" (n, 6) is Cauchy stress xx, yy, zz, xy, yz, xz [Pa].
    """

    name: str
    points: Floats
    cells: Ints
    displacement: Floats
    fields: dict[str, Floats]


@dataclass(frozen=True)
class MeshErrors:
    """A mesh and the error of its cells, at the start of a run and at its end.

    Attributes:
        t: time at which the error was found [s].
        problem: "mechanics" or "heat".
        body: name of the body.
        points: reference positions (n, 2) [m].
        cells: vertices of the cells (m, 3 or 4), dolfinx order.
        density: share of each cell in η² (40) over its share in the area of all meshes (m,) [-].
    """

    t: float
    problem: str
    body: str
    points: Floats
    cells: Ints
    density: Floats


@dataclass(frozen=True)
class RunResult:
    """Everything a run found out.

    Attributes:
        case: the case that was run.
        steps: accepted steps in order.
        interfaces: interfaces at the end.
        bodies: bodies at the end (rank 0; empty elsewhere).
        heat: their thermal meshes with "temperature" (n, 1) [K] and "heat_flux" (n, dim) [W/m²],
            likewise; empty where heat is not solved for.
        reactions: force of each held surface or grip at the end, by its name [N/m].
        probes: values at the probes, by name [SI].
        timings: seconds per phase; a dot makes a part of a phase ("contact.search") [s].
        sizes: numbers of unknowns, cells, nodes, ranks, by name.
        converged: whether the end time was reached.
        message: why it was not, else empty.
        wrong: whether that is a state that cannot be, rather than none found.
        warnings: what to doubt about accepted steps.
        first_meshes: meshes that were replaced first, by problem and body; empty without new ones.
        last_meshes: meshes at the end with their errors; empty without adaptivity.
    """

    case: Case
    steps: tuple[StepReport, ...]
    interfaces: tuple[InterfaceTable, ...]
    bodies: tuple[BodyPicture, ...]
    reactions: dict[str, tuple[float, ...]]
    probes: dict[str, float]
    timings: dict[str, float]
    sizes: dict[str, int]
    converged: bool
    message: str
    warnings: tuple[str, ...] = ()
    heat: tuple[BodyPicture, ...] = ()
    first_meshes: tuple[MeshErrors, ...] = ()
    last_meshes: tuple[MeshErrors, ...] = ()
    wrong: bool = False
