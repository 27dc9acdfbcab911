"""Random scenes by number: bodies, obstacles, meshes, loads, friction, heat, adaptivity."""

from dataclasses import dataclass, replace

import numpy as np

Pair = tuple[float, float]


@dataclass(frozen=True)
class Scene:
    """A block that is pressed, and perhaps pushed, onto another one or an obstacle; lengths in mm.

    `size` and `cells` are those of the lower and the upper block. `press` and `push` lead the top
    of the upper one. `turn` [deg] and `shift` move all of the scene, `unit` writes its lengths.
    """

    size: tuple[Pair, Pair]
    cells: tuple[tuple[int, int], tuple[int, int]]
    offset: float
    gap: float
    press: float
    push: float
    modulus: Pair
    poisson: Pair
    friction: float | None
    obstacle: bool
    kind: str
    strain: str
    steps: int
    heat: bool
    swapped: bool = False
    shift: Pair = (0.0, 0.0)
    unit: str = "mm"

    def turned_round(self) -> "Scene":
        """The scene with its sides exchanged."""
        return replace(self, swapped=not self.swapped)


def scene(number: int) -> Scene:
    """The scene of a number: the same on every machine."""
    rng = np.random.default_rng(1000 + number)
    wide = float(rng.uniform(8, 16))
    narrow = float(rng.uniform(0.4, 0.9)) * wide
    heights = rng.uniform(3, 8, 2)
    thin = float(heights.min())
    obstacle = bool(rng.random() < 0.3)
    return Scene(
        size=((wide, float(heights[0])), (narrow, float(heights[1]))),
        cells=tuple((int(rng.integers(4, 9)), int(rng.integers(2, 5))) for _ in range(2)),
        offset=float(rng.uniform(0.05, 0.95)) * (wide - narrow),
        gap=float(rng.choice((0.0, rng.uniform(0.001, 0.3)))),
        press=float(rng.uniform(0.005, 0.03)) * thin,
        push=float(rng.choice((0.0, rng.uniform(-0.1, 0.1)))) * thin,
        modulus=(float(10 ** rng.uniform(1, 4)), float(10 ** rng.uniform(1, 4))),
        poisson=(float(rng.uniform(0.0, 0.4)), float(rng.uniform(0.0, 0.4))),
        friction=None if rng.random() < 0.4 else float(rng.uniform(0.05, 0.8)),
        obstacle=obstacle,
        kind=str(rng.choice(("quadrilateral", "triangle"))),
        strain=str(rng.choice(("small", "finite"))),
        steps=int(rng.integers(2, 6)),
        heat=bool(rng.random() < 0.3),
    )


def text(s: Scene) -> str:
    """The scene as a case file."""
    lines = [
        'title = "a random scene"',
        f'strain = "{s.strain}"',
        f'time = {{ end = "1 s", step = "{1 / s.steps!r} s" }}',
        "output = { figures = false, fields = false }",
        *(['heat = { scheme = "dG(1)" }'] if s.heat else []),
        *(_material(s, k) for k in range(2)),
        *([_ground(s)] if s.obstacle else [_block(s, 0, (0.0, -s.size[0][1]))]),
        _block(s, 1, (s.offset, s.gap)),
        *_interface(s),
        *_conditions(s),
    ]
    return "\n".join(lines) + "\n"


def _length(s: Scene, value: float, axis: int | None = None) -> str:
    """A length, or a position along an axis, as it is written."""
    value += 0.0 if axis is None else s.shift[axis]
    factor = {"mm": 1.0, "m": 1e-3, "um": 1e3}[s.unit]
    return f'"{value * factor!r} {s.unit}"'


def _material(s: Scene, k: int) -> str:
    thermal = (
        'density = "7000 kg/m^3", heat_capacity = "500 J/kg/K", conductivity = "30 W/m/K", '
        'expansion = "1e-5 1/K", '
        if s.heat
        else ""
    )
    moduli = f'youngs_modulus = "{s.modulus[k]!r} MPa", poisson_ratio = {s.poisson[k]!r}'
    return f"materials.m{k} = {{ {thermal}{moduli} }}"


def _block(s: Scene, k: int, corner: Pair) -> str:
    at = f"[{_length(s, corner[0], 0)}, {_length(s, corner[1], 1)}]"
    size = f"width = {_length(s, s.size[k][0])}, height = {_length(s, s.size[k][1])}"
    cells = f'nx = {s.cells[k][0]}, ny = {s.cells[k][1]}, cell = "{s.kind}"'
    mesh = f'{{ builder = "block", corner = {at}, {size}, {cells} }}'
    return f'bodies.{("low", "up")[k]} = {{ material = "m{k}", mesh = {mesh} }}'


def _ground(s: Scene) -> str:
    at = f"[{_length(s, 0.0, 0)}, {_length(s, 0.0, 1)}]"
    return f'obstacles.ground = {{ shape = "plane", point = {at}, normal = [0.0, 1.0] }}'


def _interface(s: Scene) -> list[str]:
    sides = ["up.bottom", "ground" if s.obstacle else "low.top"]
    if s.swapped and not s.obstacle:
        sides.reverse()
    lines = ["[interfaces.c]", f'nonmortar = "{sides[0]}"', f'mortar = "{sides[1]}"']
    if s.friction is not None:
        lines.append(f"friction = {{ coefficient = {s.friction!r} }}")
    if s.heat:
        lines.append('heat = { law = "constant", conductance = "1000 W/m^2/K" }')
    return lines


def _conditions(s: Scene) -> list[str]:
    down = f'[["0 s", "0 mm"], ["0.5 s", {_length(s, -s.gap - s.press)}]]'
    side = f'[["0.5 s", "0 mm"], ["1 s", {_length(s, s.push)}]]'
    lines = ["[[conditions]]", 'on = "up.top"', f"displacement = {{ x = {side}, y = {down} }}"]
    if not s.obstacle:
        lines += ["[[conditions]]", 'on = "low.bottom"', 'displacement = ["0 mm", "0 mm"]']
    if s.heat:
        lines += [
            "[[conditions]]",
            'on = "up.top"',
            'temperature = [["0 s", "0 K"], ["1 s", "40 K"]]',
        ]
        if not s.obstacle:
            lines += ["[[conditions]]", 'on = "low.bottom"', 'temperature = "0 K"']
    return lines
