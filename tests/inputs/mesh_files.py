"""Writes two blocks that are pressed together, in the ways in which others write meshes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contactfem.common.typing import Floats, Ints

# 10 MPa everywhere, in plane strain: the sole goes down by p (1 - nu^2)/E times the lower height,
# the top by that of both
PRESSED = """
title = "Two blocks pressed together"
strain = "small"
time = { end = "1 s", step = "1 s" }
output = { fields = false, figures = false }
[materials.steel]
youngs_modulus = "200 GPa"
poisson_ratio = 0.25
[bodies.upper]
material = "steel"
mesh = { file = "FILE", unit = "mm", body = "upper" }
[bodies.lower]
material = "steel"
mesh = { file = "FILE", unit = "mm", body = "lower" }
[interfaces.rub]
nonmortar = "upper.sole"
mortar = "lower.track"
[[conditions]]
on = "lower.base"
displacement.y = "0 mm"
[[conditions]]
on = "lower.lower_left"
displacement.x = "0 mm"
[[conditions]]
on = "upper.upper_left"
displacement.x = "0 mm"
[[conditions]]
on = "upper.top"
pressure = "10 MPa"
[expect]
"rub.pressure_max" = { value = "10 MPa", rel = 1e-4 }
"rub.pressure_min" = { value = "10 MPa", rel = 1e-4 }
"upper.displacement_y.min" = { value = "-6.5625e-4 mm", rel = 1e-4 }
"""


@dataclass(frozen=True)
class Block:
    """Nodes (n, 2) [mm], triangles (m, 3) and quadrilaterals (q, 4), and the sides by node."""

    name: str
    points: Floats
    triangles: Ints
    quads: Ints
    sides: dict[str, Ints]


def block(name: str, nx: int, ny: int, low: float, high: float, quads: int = 0) -> Block:
    """A block of width 12 with an uneven mesh, the first `quads` columns of quadrilaterals."""
    x, y = np.meshgrid(np.linspace(0.0, 12.0, nx + 1), np.linspace(low, high, ny + 1))
    inner = (slice(1, -1), slice(1, -1))
    x[inner] += 0.5 * np.sin(5.0 * x[inner] + 3.0 * y[inner])
    number = np.arange(x.size).reshape(x.shape)
    around = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1)
    kept, split = around[:, :quads].reshape(-1, 4), around[:, quads:].reshape(-1, 4)
    triangles = np.concatenate([split[:, [0, 1, 2]], split[:, [0, 2, 3]]])
    bottom, top = ("sole", "top") if name == "upper" else ("base", "track")
    sides = {bottom: number[0], top: number[-1], f"{name}_left": number[:, 0]}
    return Block(name, np.stack([x.ravel(), y.ravel()], axis=1), triangles, kept, sides)


def blocks(quads: int = 0) -> tuple[Block, Block]:
    """The upper one, 8 high, and the lower one, 6 high; they touch with different nodes."""
    return block("upper", 5, 4, 0.0, 8.0, quads), block("lower", 7, 3, -6.0, 0.0, quads)


def write_case(folder: Path, file: str) -> Path:
    """Write the case of blocks from a mesh file."""
    path = folder / "case.toml"
    path.write_text(PRESSED.replace("FILE", file))
    return path


def write_msh(
    path: Path, bodies: tuple[Block, ...], twice: bool = False, shared: bool = False
) -> None:
    """Write gmsh's format 2.2.

    `twice`: all cells are in a second group too, as gmsh has it. `shared`: all have the nodes of
    the first body.
    """
    names, rows, nodes = [], [], []
    for tag, body in enumerate(bodies, start=1):
        names.append(f'2 {tag} "{body.name}"')
        first = 1 if shared else len(nodes) + 1
        points = body.points.tolist() if not shared or not nodes else []
        nodes += [f"{first + k} {x!r} {y!r} 0" for k, (x, y) in enumerate(points)]
        for group in (tag, 9) if twice else (tag,):
            rows += [f"2 2 {group} {tag} {_row(cell + first)}" for cell in body.triangles]
            rows += [f"3 2 {group} {tag} {_row(cell + first)}" for cell in body.quads]
        for k, (side, line) in enumerate(body.sides.items(), start=10 * tag):
            names.append(f'1 {k} "{side}"')
            edges = np.stack([line[:-1], line[1:]], axis=1) + first
            rows += [f"1 2 {k} {k} {_row(edge)}" for edge in edges]
    names += ['2 9 "all"'] if twice else []
    elements = [f"{k} {row}" for k, row in enumerate(rows, start=1)]
    text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    for title, part in (("PhysicalNames", names), ("Nodes", nodes), ("Elements", elements)):
        text += "\n".join([f"${title}", str(len(part)), *part, f"$End{title}"]) + "\n"
    path.write_text(text)


def _row(numbers: Ints, between: str = " ") -> str:
    return between.join(map(str, numbers.tolist()))


def write_inp(
    path: Path, bodies: tuple[Block, ...], element: str = "CPE", turn: bool = False
) -> None:
    """Write parts and instances as Abaqus/CAE does, with faces for the lower body.

    `turn`: the part of the upper body lies on its side, and its instance puts it up.
    """
    text = "*Heading\n** Job name: press\n"
    for body in bodies:
        turned = turn and body.name == "upper"
        points = body.points @ np.array([[0.0, -1.0], [1.0, 0.0]]) if turned else body.points
        points = points + np.array([3.0, 4.0]) * turned
        text += f"*Part, name={body.name}-part\n*Node\n"
        text += "".join(f"{k}, {x!r}, {y!r}\n" for k, (x, y) in enumerate(points.tolist(), start=1))
        text += f"*Element, type={element}3\n"
        text += _numbered(body.triangles, 1)
        if len(body.quads):
            text += f"*Element, type={element}4R\n{_numbered(body.quads, 1 + len(body.triangles))}"
        text += "".join(
            f"*Nset, nset={n}\n{_row(line + 1, ', ')}\n" for n, line in body.sides.items()
        )
        text += "*End Part\n"
    text += "*Assembly, name=Assembly\n"
    for body in bodies:
        text += f"*Instance, name={body.name}, part={body.name}-part\n"
        if turn and body.name == "upper":
            text += "-3., -4., 0.\n0., 0., 0., 0., 0., 1., 90.\n"
        text += "*End Instance\n"
    path.write_text(text + "*End Assembly\n*Step\n*Static\n1., 1.\n*End Step\n")


def _numbered(cells: Ints, first: int) -> str:
    rows = enumerate((cells + 1).tolist(), start=first)
    return "".join(f"{k}, {', '.join(map(str, row))}\n" for k, row in rows)
