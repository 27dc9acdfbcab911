"""Structure: packages import from floors below only, and heavy or parallel libraries stay put."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# A package imports only from packages that stand before it.
PLAIN = """
    errors common geometry laws forms kernels _kernels meshes audit verification case results check
"""
DISCRETE = "fem mortar contact mechanics heat transfer solvers thermomechanics"
ORDER = [
    *PLAIN.split(), *DISCRETE.split(),
    "discretisation", "adaptivity", "checkpoint", "output", "run", "study", "cli",
]  # fmt: skip
# Modules of later packages that do without MPI, PETSc and dolfinx as well
ALSO_PLAIN = """
    adaptivity.decisions adaptivity.policies adaptivity.sizes adaptivity.mesh_decision
    adaptivity.recovery checkpoint.archive checkpoint.format output.tables output.terminal
    output.figures output.report run.step_control run.signals run.resume study cli.main
"""
PARALLEL = {"contactfem.study.suite"}
NEVER = {  # rules beside the order: a package and those it must not know
    "heat": {"mechanics", "contact", "case"},
    "mechanics": {"heat", "case", "solvers"},
    "contact": {"heat", "case", "solvers", "mechanics"},
    "mortar": {"case"},
    "transfer": {"case"},
    "solvers": {"case", "heat"},
    "thermomechanics": {"case"},
    "laws": {"meshes", "fem"},
    "audit": {"laws", "case"},
}
COMMAND_LINE = {"cli"}
MPI = {"dolfinx", "mpi4py", "petsc4py"}
SLOW_TO_IMPORT = MPI | {"basix", "gmsh", "matplotlib", "meshio", "scipy", "ufl"}


def sources() -> list[Path]:
    folders = ("contactfem", "forms", "meshes")
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def module(path: Path) -> str:
    """Dotted name of a file as it is imported: forms/x.py is contactfem.forms.x."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts if parts[0] == "contactfem" else ("contactfem", *parts)
    return ".".join(parts).removesuffix(".__init__")


def package(name: str) -> str:
    """Package of a dotted name: contactfem.case.read is in case."""
    return name.split(".")[1] if "." in name else ""


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def imported(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    assert isinstance(node, ast.ImportFrom)
    assert node.level == 0, f"line {node.lineno}: a relative import"
    assert node.module is not None
    if node.module == "contactfem":
        return [f"contactfem.{alias.name}" for alias in node.names]
    return [node.module]


def imports(node: ast.AST, *, everywhere: bool) -> Iterator[str]:
    """Yield the dotted names imported below `node`.

    `everywhere`: inside functions and for type checkers as well, not only when it is loaded.
    """
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield from imported(child)
        elif everywhere or not (
            isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            or (isinstance(child, ast.If) and ast.unparse(child.test).endswith("TYPE_CHECKING"))
        ):
            yield from imports(child, everywhere=everywhere)


def loaded(path: Path) -> set[str]:
    """What a file imports outside of the package when it runs, inside functions too."""
    found: set[str] = set()

    def visit(node: ast.AST) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import | ast.ImportFrom):
                found.update(name.split(".")[0] for name in imported(child))
            elif not (
                isinstance(child, ast.If) and ast.unparse(child.test).endswith("TYPE_CHECKING")
            ):
                visit(child)

    visit(tree(path))
    return found


@cache
def modules() -> dict[str, Path]:
    return {module(path): path for path in sources()}


def internal(path: Path, *, everywhere: bool) -> set[str]:
    """Modules of the package that a file imports, other than itself."""
    found = set()
    for name in imports(tree(path), everywhere=everywhere):
        if name == "contactfem" or not name.startswith("contactfem."):
            continue
        found.add(name)
    return found - {module(path), "contactfem.__version__"}


def at_start(name: str, seen: set[str]) -> set[str]:
    """Everything outside the package that importing one module of it loads."""
    seen.add(name)
    found: set[str] = set()
    parts = name.split(".")
    for part in (".".join(parts[:k]) for k in range(2, len(parts) + 1)):
        if (path := modules().get(part)) is None:
            continue
        for below in imports(tree(path), everywhere=False):
            if not below.startswith("contactfem"):
                found.add(below.split(".")[0])
            elif below not in seen:
                found |= at_start(below, seen)
    return found


def test_packages_import_from_floors_below() -> None:
    known = {package(module(path)) for path in sources()} - {"", "__main__"}
    assert known <= set(ORDER), "give the new package its place in ORDER"
    upward = {
        f"{path.relative_to(ROOT)} imports {name}"
        for path in sources()
        if (own := package(module(path))) in ORDER
        for name in internal(path, everywhere=True)
        if ORDER.index(package(name)) > ORDER.index(own) or package(name) in NEVER.get(own, ())
    }
    assert upward == set()


def test_no_package_has_a_circle() -> None:
    graph = {
        name: {to for to in internal(path, everywhere=True) if to in modules()}
        for name, path in modules().items()
    }
    done: set[str] = set()

    def visit(name: str, way: tuple[str, ...]) -> None:
        assert name not in way, " -> ".join((*way[way.index(name) :], name))
        if name not in done:
            for to in graph[name]:
                visit(to, (*way, name))
            done.add(name)

    for name in graph:
        visit(name, ())


def test_every_module_says_what_it_is_for() -> None:
    assert [path for path in sources() if not ast.get_docstring(tree(path))] == []


def test_only_the_command_line_knows_the_world_and_prints() -> None:
    names = {
        f"{path.relative_to(ROOT)}: {ast.unparse(node)}"
        for path in sources()
        if package(module(path)) not in COMMAND_LINE and module(path) != "contactfem.run.api"
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Attribute | ast.Name)
    }
    assert {name for name in names if name.endswith((": print", "COMM_WORLD"))} == set()


def test_dolfinx_versions_are_told_apart_in_one_place() -> None:
    telling = {module(path) for path in sources() if "dolfinx.__version__" in path.read_text()}
    assert telling <= {"contactfem.fem.compat"}


def test_forms_are_pure_ufl() -> None:
    for path in (ROOT / "forms").rglob("*.py"):
        allowed = {"basix", "collections", "contactfem", "dataclasses", "math", "typing", "ufl"}
        assert loaded(path) <= allowed, path
        assert {package(name) for name in internal(path, everywhere=True)} <= {"forms"}


def test_plain_modules_do_without_mpi() -> None:
    plain = tuple(f"contactfem.{name}" for name in (*PLAIN.split(), *ALSO_PLAIN.split()))
    using = {
        name
        for name, path in modules().items()
        if name not in PARALLEL
        and any(name == one or name.startswith(f"{one}.") for one in plain)
        and loaded(path) & MPI
    }
    assert using == set()


@pytest.mark.parametrize("name", ["contactfem.check.check", "contactfem.cli.main"])
def test_the_program_starts_without_heavy_packages(name: str) -> None:
    assert not at_start(name, set()) & SLOW_TO_IMPORT


# Where each equation of the paper stands, under its number
EQUATIONS = {
    "contactfem/mortar/normals": [1],
    "contactfem/mortar/operators": [2, 7, 8, 9, 10, 11],
    "contactfem/contact/slip": [3],
    "contactfem/laws/complementarity": [4, 5, 6, 13],
    "contactfem/mechanics/condensed": [8, 11],
    "contactfem/laws/conductance": [15],
    "contactfem/laws/frictional_heat": [16, 17],
    "contactfem/mechanics/bulk_system": [18],
    "contactfem/heat/system": [18],
    "contactfem/heat/interface": [21],
    "contactfem/heat/time_schemes": list(range(22, 28)),
    "contactfem/thermomechanics/body_transfer": [28],
    "contactfem/transfer/volume": [29],
    "contactfem/transfer/surface": [30, 31],
    "contactfem/adaptivity/recovery/norms": [32],
    "contactfem/adaptivity/recovery/patches": [33],
    "contactfem/adaptivity/recovery/interface": [34, 35],
    "contactfem/adaptivity/recovery/constraints": [36],
    "contactfem/adaptivity/recovery/time": [37, 38, 39],
    "contactfem/results/relative_error": [40],
    "contactfem/adaptivity/sizes": [41],
    "forms/heat": [12, 20],
    "forms/energies": [14],
    "forms/mechanics": [19],
}


def numbers(text: str) -> set[int]:
    """Equation numbers in a text: (7), and all of (7)-(11)."""
    found = {int(n) for n in re.findall(r"\((\d+)\)", text)}
    for low, high in re.findall(r"\((\d+)\)\s*(?:-|to)\s*\((\d+)\)", text):
        found |= set(range(int(low), int(high) + 1))
    return found


@pytest.mark.parametrize("place", EQUATIONS)
def test_equations_stand_where_the_paper_s_reader_looks(place: str) -> None:
    path = ROOT / f"{place}.py"
    docs = [
        ast.get_docstring(node) or ""
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
    ]
    missing = set(EQUATIONS[place]) - set().union(*(numbers(text) for text in docs))
    assert missing == set()


def test_every_equation_has_a_place() -> None:
    assert set().union(*(set(found) for found in EQUATIONS.values())) == set(range(1, 42))


def test_the_first_line_of_a_module_is_short() -> None:
    long = {
        str(path.relative_to(ROOT)): line
        for path in sources()
        if len((line := (ast.get_docstring(tree(path)) or "").split("\n")[0]).split()) > 12
    }
    assert long == {}


def test_every_package_is_installed() -> None:
    """setup.py finds packages below contactfem by itself, but forms and meshes are named there."""
    folders = {path.parent for path in sources()} - {ROOT / "forms", ROOT / "meshes"}
    inside = {folder for folder in folders if folder.is_relative_to(ROOT / "contactfem")}
    assert folders - inside == set()
    assert {folder for folder in inside if not (folder / "__init__.py").exists()} == set()
