"""What the look finds in made-up states, each with one thing that cannot be."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from contactfem.audit.files import NAME, read_state, write_state
from contactfem.audit.forces import BodyForces, ContactForces, HeatTerms, breaches_of_heat
from contactfem.audit.loads import in_volume, of_pressure, on_surface
from contactfem.audit.look import AuditState, look
from contactfem.audit.shapes import BodyShape, ObstacleShape


def block(name: str, bottom: float, nx: int) -> BodyShape:
    """A block of unit height and width."""
    x, y = np.meshgrid(np.linspace(0, 1, nx + 1), (bottom, bottom + 1.0))
    points = np.column_stack((x.ravel(), y.ravel()))
    k = np.arange(nx)
    cells = np.column_stack((k, k + 1, k + nx + 1, k + nx + 2))
    return BodyShape(name, points, points, cells, "quadrilateral")


LOWER, UPPER = block("lower", 0.0, 3), block("upper", 1.0, 2)


def contact() -> ContactForces:
    """Three nonmortar nodes below the upper block press on the four of the lower one."""
    x = np.concatenate((UPPER.X[:3], LOWER.X[4:]))
    upward = np.array((0.5, 1.0, 0.5)) * 50.0
    force = np.zeros((7, 2))
    force[:3, 1] = upward
    force[3:, 1] = -np.array((1, 2, 2, 1)) * 100.0 / 6.0
    force[:3, 0] = 0.1 * upward
    force[3:, 0] = 0.1 * force[3:, 1]
    down = np.tile((0.0, -1.0), (3, 1))
    zero = np.zeros(3)
    return ContactForces(
        "joint", "upper", "lower", x, down, force, 0.2 * upward, zero, 0.01 * upward, zero
    )


def state() -> AuditState:
    """Two blocks on each other, pressed by 100 N/m and pulled by 10."""
    pull = np.array((-10.0, -100.0))
    forces = (
        BodyForces("lower", np.zeros(2), -pull, 100.0, 1e-9),
        BodyForces("upper", pull, np.zeros(2), 100.0, 1e-9),
    )
    return AuditState(1.0, (LOWER, UPPER), (), (contact(),), forces, frozenset(("upper",)), 3.0)


def kinds(at: AuditState) -> list[str]:
    return [breach.kind for breach in look(at).breaches]


def with_contact(**changes: object) -> AuditState:
    return replace(state(), contacts=(replace(contact(), **changes),))


def test_nothing_is_wrong_with_a_state_in_order() -> None:
    assert look(state()).breaches == ()


def sunk() -> AuditState:
    return replace(state(), bodies=(LOWER, UPPER.moved(UPPER.x - np.array((0.0, 0.1)))))


def thrown() -> AuditState:
    return replace(state(), bodies=(LOWER, UPPER.moved(UPPER.x + np.array((52.0, 0.0)))))


def turned() -> AuditState:
    upside_down = UPPER.x * np.array((1.0, -1.0)) + np.array((0.0, 3.0))
    return replace(state(), bodies=(LOWER, UPPER.moved(upside_down)))


def nowhere() -> AuditState:
    return replace(state(), bodies=(LOWER, UPPER.moved(UPPER.x * np.nan)))


def unbalanced() -> AuditState:
    lower, upper = state().forces
    return replace(state(), forces=(lower, replace(upper, loads=upper.loads * 1.001)))


def one_sided() -> AuditState:
    force = contact().force.copy()
    force[3:] *= 1.001
    return replace(with_contact(force=force), forces=())


def pulling() -> AuditState:
    force = contact().force.copy()
    force[:3, 1] = -10.0, 120.0, -10.0
    return replace(with_contact(force=force), forces=())


def above_its_bound() -> AuditState:
    return with_contact(bound=0.05 * contact().force[:3, 1])


def giving_work() -> AuditState:
    return with_contact(work=-contact().work)


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (sunk, "depth", "'upper' is 0.1 m deep in 'lower'"),
        (thrown, "motion", "'upper', which nothing but contact holds, has moved by 52 m"),
        (turned, "cells", "2 of 2 cells of body 'upper'"),
        (nowhere, "motion", "nowhere"),
        (unbalanced, "balance", "'upper' leave 0.1 N/m over"),
        (one_sided, "action and reaction", "differ by 0.1 N/m"),
        (pulling, "pressure", "pulls with 10 N/m at (0, 1) m"),
        (above_its_bound, "friction", "above its bound 2.5 N/m"),
        (giving_work, "friction", "instead of taking work"),
    ],
    ids=lambda value: value.__name__ if callable(value) else None,
)
def test_what_cannot_be_is_found(make: Callable[[], AuditState], kind: str, words: str) -> None:
    found = look(make())
    assert {breach.kind for breach in found.breaches} == {kind}
    assert any(words in str(breach) for breach in found.breaches), str(found)
    assert "\n" not in str(found)


@pytest.mark.parametrize(
    ("stored", "friction", "words"),
    [(1.01, 0.0, "0.01 J/m of heat come from nowhere"), (0.5, -0.5, "friction takes 0.5 J/m")],
)
def test_heat_that_cannot_be_is_found(stored: float, friction: float, words: str) -> None:
    sources = {"prescribed": 1.0, "friction": friction}
    (found,) = breaches_of_heat(HeatTerms(stored, sources))
    assert words in str(found)
    assert list(breaches_of_heat(HeatTerms(stored, sources, noise=1.0))) == []


def test_a_compliant_law_may_let_nodes_in() -> None:
    let_in = replace(sunk(), contacts=(replace(contact(), give=np.full(3, 0.06)),))
    assert kinds(let_in) == []


def test_bodies_behind_an_obstacle_that_is_not_theirs_are_fine() -> None:
    wall = ObstacleShape("wall", "plane", np.array(((5.0, 0.0), (1.0, 0.0))))
    assert kinds(replace(state(), obstacles=(wall,))) == []
    met = replace(contact(), mortar="wall")
    found = kinds(replace(state(), obstacles=(wall,), contacts=(met,), forces=()))
    assert found == ["depth"]


def test_a_state_comes_back_from_its_file(tmp_path) -> None:
    floor = ObstacleShape("floor", "plane", np.array(((0.0, 0.0), (0.0, 1.0))))
    for at in (state(), replace(sunk(), obstacles=(floor,), axisymmetric=True)):
        write_state(tmp_path, at)
        again = read_state(tmp_path)
        assert look(again) == look(at)
        assert again.unrestrained == at.unrestrained
        np.testing.assert_array_equal(again.contacts[0].force, at.contacts[0].force)
    assert [path.name for path in tmp_path.iterdir()] == [NAME]


def test_resultants_of_loads() -> None:
    body = block("block", 0.0, 4)
    top = np.array([(8, 7), (7, 6), (6, 5)]) + 1  # outward, three of four facets
    t = np.array((1.0, 2.0))
    np.testing.assert_allclose(on_surface(body.X, top, t, axisymmetric=False), 0.75 * t)
    pressed = of_pressure(body.X, top, 4.0, axisymmetric=False)
    np.testing.assert_allclose(pressed, (0.0, -3.0), atol=1e-15)
    # around the axis: rings from r = 1/4 to 1, and the whole disk
    ring = np.pi * (1.0 - 0.25**2)
    np.testing.assert_allclose(on_surface(body.X, top, t, axisymmetric=True), ring * t)
    np.testing.assert_allclose(in_volume(body, t, axisymmetric=True), np.pi * t)
    np.testing.assert_allclose(in_volume(body, t, axisymmetric=False), t)
