"""Structure: imports point down only, and heavy or parallel packages stay where they belong."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# A module imports only modules that stand before it; forms, meshes and kernels stand for their own.
PLAIN = """
    errors dimensions tables functions units timers laws results verdicts magnification references
    control renewal forms kernels _kernels homogeneous engineering overrides profiles
    time_schemes ringing
    heat_laws heat_references heat_transients manufactured
    thermoelastic_references thermoelastic_stability boxes nearest
    meshes model interface_laws scene element_choice relative_error error_measure heat_measure
    measure contradictions heat_links adaptivity_links case_links case_errors case friction_choice
    listing
    gaps rigid shapes location constants facets
    archive checkpoint
    expect facts heat_words adaptivity_words plausible check mesh_files key_words case_reference
    charts interface_figure pictures heat_figure errors_figure meshes_figure figures snapshots
    film output
    report_table adaptivity_report report terminal resume
    markup html_style html_steps html_report
    refinement families trial orders study_table study_figure study
    stop stops
    recovery constrained_recovery interface_recovery space_error time_error
    sizes adaptivity mesh_choice
"""  # these work without MPI, PETSc and dolfinx
PARALLEL = """
    compat petsc_options jit_cache meshing blocks sparse transfer projection mesh_view boundary_data
    body_recovery surfaces directions crosspoints segments mortar motion
    contact balance rim
    elements mechanics numbering system tangent interface coupling condensed saddle stability doubt
    direct schur held dense substructure interface_matrix on_interfaces constant reused
    linear_solver newton
    heat heat_interface heat_matrix heat_system thermal
    discretise_heat fields body_meshes discretise diagnosis state staggered heat_record
    observed estimate surface_cells remesh adapt gathering recorder
    packing snapshot keeper first_contact loop outcome run
    suite cli_run cli_study cli
"""
ORDER = (PLAIN + PARALLEL).split()
COMMAND_LINE = {"cli", "cli_run"}
MPI = {"dolfinx", "mpi4py", "petsc4py"}
SLOW_TO_IMPORT = MPI | {"basix", "gmsh", "matplotlib", "meshio", "scipy", "ufl"}


def sources() -> list[Path]:
    folders = ("contactfem", "forms", "meshes")
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def module(path: Path) -> str:
    """Name a file as ORDER does: contactfem/case.py is case, forms/x.py is forms."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return parts[1] if parts[0] == "contactfem" else parts[0]


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


def imports(node: ast.AST, *, inside_functions: bool) -> Iterator[str]:
    """Yield the dotted names imported below `node`, but not those only type checkers see."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield from imported(child)
        elif isinstance(child, ast.If) and ast.unparse(child.test).endswith("TYPE_CHECKING"):
            continue
        elif inside_functions or not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from imports(child, inside_functions=inside_functions)


def external(path: Path, *, inside_functions: bool) -> set[str]:
    return {name.split(".")[0] for name in imports(tree(path), inside_functions=inside_functions)}


def internal(path: Path, *, inside_functions: bool) -> set[str]:
    """Parts of the package that a file imports, other than its own."""
    names = [name.split(".") for name in imports(tree(path), inside_functions=inside_functions)]
    parts = {name[1] for name in names if name[0] == "contactfem" and len(name) > 1}
    return parts - {module(path), "__version__"}


def at_start(part: str, seen: set[str]) -> set[str]:
    """Everything outside the package that importing one part of it loads."""
    loaded: set[str] = set()
    for path in sources():
        if module(path) == part:
            loaded |= external(path, inside_functions=False)
            for below in internal(path, inside_functions=False) - seen:
                loaded |= at_start(below, seen | {part})
    return loaded


def test_imports_point_down() -> None:
    modules = [path for path in sources() if module(path) not in ("__init__", "__main__")]
    assert {module(path) for path in modules} <= set(ORDER), (
        "give the new module its place in ORDER"
    )
    upward = {
        f"{path.relative_to(ROOT)} imports {part}"
        for path in modules
        for part in internal(path, inside_functions=True)
        if part not in ORDER[: ORDER.index(module(path))]
    }
    assert upward == set()


def test_every_module_says_what_it_is_for() -> None:
    assert [path for path in sources() if not ast.get_docstring(tree(path))] == []


def test_only_the_command_line_knows_the_world_and_prints() -> None:
    names = {
        f"{path.relative_to(ROOT)}: {ast.unparse(node)}"
        for path in sources()
        if module(path) not in COMMAND_LINE
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Attribute | ast.Name)
    }
    assert {name for name in names if name.endswith((": print", "COMM_WORLD"))} == set()


def test_dolfinx_versions_are_told_apart_in_one_place() -> None:
    telling = {module(path) for path in sources() if "dolfinx.__version__" in path.read_text()}
    assert telling <= {"compat"}


def test_forms_are_pure_ufl() -> None:
    for path in (ROOT / "forms").rglob("*.py"):
        allowed = {"basix", "collections", "contactfem", "dataclasses", "math", "typing", "ufl"}
        assert external(path, inside_functions=True) <= allowed, path
        assert internal(path, inside_functions=True) == set(), path


def test_plain_modules_do_without_mpi() -> None:
    plain = [path for path in sources() if module(path) in PLAIN.split()]
    assert [path for path in plain if external(path, inside_functions=True) & MPI] == []


@pytest.mark.parametrize("part", ["check", "cli"])
def test_the_program_starts_without_heavy_packages(part: str) -> None:
    assert not at_start(part, set()) & SLOW_TO_IMPORT


def test_every_package_is_installed() -> None:
    """setup.py finds packages below contactfem by itself, but forms and meshes are named there."""
    folders = {path.parent for path in sources()} - {ROOT / "forms", ROOT / "meshes"}
    inside = {folder for folder in folders if folder.is_relative_to(ROOT / "contactfem")}
    assert folders - inside == set()
    assert {folder for folder in inside if not (folder / "__init__.py").exists()} == set()
