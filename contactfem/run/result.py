"""Result of a run, gathered on the first rank."""

import time

from contactfem.case.schema import Case
from contactfem.checkpoint.format import Progress
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.output.gather import body_pictures, heat_pictures, interface_tables, probe_values
from contactfem.results.data import RunResult


def outcome(
    case: Case,
    discretisation: Discretisation,
    state: State,
    progress: Progress,
    timers: Timers,
    start: float,
    message: str,
) -> RunResult:
    """Result of a run; collective.

    Args:
        case: The case.
        discretisation: Its last meshes.
        state: The last good state.
        progress: The steps up to there.
        timers: Where time was booked.
        start: When the run started, by `time.perf_counter` [s].
        message: Why the end was not reached; empty if it was.

    Returns:
        The result; pictures and probes on the first rank only.
    """
    with timers.book("output"):
        pictures = body_pictures(discretisation) if case.mechanics else []
        heat = heat_pictures(discretisation, state)
        probes = probe_values(case, pictures, heat)
        tables = interface_tables(discretisation, state)
    reactions: dict[str, tuple[float, ...]] = {
        name: (force,) for name, force in zip(discretisation.held, progress.reactions, strict=False)
    }
    system = discretisation.system
    sizes = {
        "unknowns": system.numbering.n_global,
        "ranks": system.comm.size,
        "nonmortar_nodes": sum(i.nodes.mesh.n_nonmortar for i in discretisation.interfaces),
        "factorisations": timers.counts.get("factorisation", 0),
    }
    if discretisation.heat is not None:
        sizes["temperatures"] = discretisation.heat.system.numbering.n_global
    timers.add("total", time.perf_counter() - start)
    seconds = dict(timers.seconds)
    seconds["contact"] = sum(v for k, v in seconds.items() if k.startswith("contact."))
    return RunResult(
        case, progress.reports, tuple(tables), tuple(pictures), reactions, probes, seconds, sizes,
        not message, message, warnings=progress.warnings, heat=tuple(heat),
    )  # fmt: skip
