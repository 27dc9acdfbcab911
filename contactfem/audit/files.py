"""Write the last state of a run, and look at it again."""

import json
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from contactfem.audit.breach import Breach
from contactfem.audit.forces import BodyForces, ContactForces, HeatTerms, breaches_of_heat
from contactfem.audit.look import AuditState, Finding, look
from contactfem.audit.shapes import BodyShape, ObstacleShape
from contactfem.common.typing import Floats
from contactfem.errors import CaseError

NAME = "last_state.npz"
RECORDS = {
    "bodies": BodyShape,
    "obstacles": ObstacleShape,
    "contacts": ContactForces,
    "forces": BodyForces,
}
NOISE = 1e-10  # of the heat that bodies hold or conduct at a temperature of
COLD = 1e-3  # at least [K]
NEGATIVE = 1e-9  # of all work of friction that a step may seem to give back


def write_state(folder: Path, state: AuditState) -> None:
    """Write a state into the folder of a run.

    Args:
        folder: The folder.
        state: The state.

    Raises:
        OSError: It cannot be written.
    """
    arrays: dict[str, Floats] = {}
    head: dict[str, Any] = {
        "t": state.t,
        "unrestrained": sorted(state.unrestrained),
        "scene": state.scene,
        "travel": state.travel,
        "axisymmetric": state.axisymmetric,
        "holding": state.holding,
    }
    for part in RECORDS:
        head[part] = [
            _split(record, f"{part}.{k}", arrays) for k, record in enumerate(getattr(state, part))
        ]
    arrays["head"] = np.array(json.dumps(head))
    np.savez(folder / NAME, **arrays)  # type: ignore[arg-type]


def read_state(folder: Path) -> AuditState:
    """Read the last state of a run.

    Args:
        folder: The folder of the run.

    Raises:
        CaseError: There is none that can be read.
    """
    path = folder / NAME
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        head = json.loads(str(arrays.pop("head")))
        parts = {
            part: tuple(
                kind(**values, **_arrays_of(arrays, f"{part}.{k}."))
                for k, values in enumerate(head.pop(part))
            )
            for part, kind in RECORDS.items()
        }
        head["holding"] = tuple(head["holding"])
        head["unrestrained"] = frozenset(head["unrestrained"])
        return AuditState(**head, **parts)
    except FileNotFoundError:
        raise CaseError(
            f"{path}: there is no such file: a run writes it at its end unless solver.verify is "
            "false"
        ) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise CaseError(f"{path}: cannot be read: {error}") from None


def verify(folder: Path, summary: dict[str, Any]) -> list[Finding]:
    """Look at the last state of a run and at the numbers of all its steps.

    Args:
        folder: The folder of the run.
        summary: What its summary.json holds.

    Returns:
        What was found, by time; empty where all is well.

    Raises:
        CaseError: The last state is not there.
    """
    state = read_state(folder)
    found = [
        finding
        for step in summary["steps"]
        if (finding := Finding(step["t"], tuple(_of_step(step, state.holding)))).breaches
    ]
    last = look(state)
    return [*found, last] if last.breaches else found


def _of_step(step: dict[str, Any], holding: tuple[float, float]) -> Iterator[Breach]:
    """What the numbers of a step cannot be."""
    if step["dissipation"] < 0.0 and abs(step["dissipation"]) > NEGATIVE * _force_times_step(step):
        yield Breach(
            "friction",
            f"friction gives {-step['dissipation']:.3g} J/m instead of taking work",
            "a smaller time step may help",
        )
    heat = step["heat"]
    if heat is not None:
        yield from breaches_of_heat(heat_terms(heat, step["dt"], holding))


def _force_times_step(step: dict[str, Any]) -> float:
    """A scale for work: the largest force of the interfaces, by a metre [J/m]."""
    return max((float(np.hypot(*force)) for force in step["forces"].values()), default=0.0)


def heat_terms(heat: dict[str, Any], dt: float, holding: tuple[float, float]) -> HeatTerms:
    """Heat of a step by where it came from.

    Args:
        heat: Fields of a `HeatStep`.
        dt: Length of the step [s].
        holding: Heat capacity of all bodies [J/m/K], and their largest conductivity [W/m/K].
    """
    sources = {name: heat[name] for name in ("loads", "friction", "obstacles", "strained")}
    passed = dt * max(map(abs, heat["flow"].values()), default=0.0)
    hottest = max(abs(heat["temperature_min"]), abs(heat["temperature_max"]), COLD)
    noise = NOISE * hottest * (holding[0] + dt * holding[1])
    return HeatTerms(heat["stored"], sources | heat["held"], passed, noise)


def _split(record: Any, prefix: str, arrays: dict[str, Floats]) -> dict[str, Any]:
    """Plain values of a record; its arrays go to others by name."""
    plain = {}
    for field in fields(record):
        value = getattr(record, field.name)
        if isinstance(value, np.ndarray):
            arrays[f"{prefix}.{field.name}"] = value
        else:
            plain[field.name] = value
    return plain


def _arrays_of(arrays: dict[str, Floats], prefix: str) -> dict[str, Floats]:
    """Arrays whose names begin with a prefix, without it."""
    return {
        name.removeprefix(prefix): value
        for name, value in arrays.items()
        if name.startswith(prefix)
    }
