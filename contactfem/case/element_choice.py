"""The finite element of a body: P1, Q1 or MINI."""

from typing import Literal

from contactfem.case.materials import Material
from contactfem.case.scene import Body

SIMPLICES = ("triangle", "tetrahedron")
INCOMPRESSIBLE = 20.0  # K/μ, that is ν = 0.475, above which linear simplices are far too stiff


def element_of(body: Body, material: Material, cell: str) -> Literal["P1", "MINI"]:
    """Element of a body.

    Args:
        body: The body.
        material: Its material.
        cell: Kind of its cells.

    Returns:
        What the body asks for; if that is "auto", MINI on simplices where K/μ > 20.
    """
    if body.element != "auto":
        return body.element
    return "MINI" if can_be_mini(material, cell) and locks(material) else "P1"


def can_be_mini(material: Material, cell: str) -> bool:
    """Whether MINI is there for these cells, and the material's energy has a mixed form."""
    return cell in SIMPLICES and material.model == "neo-hooke"


def locks(material: Material) -> bool:
    """Whether a displacement element is far too stiff for a material, K/μ > 20."""
    return material.K / material.mu > INCOMPRESSIBLE


def describe_element(body: Body, material: Material, cell: str) -> str:
    """Element, cells and why, in words, with a warning where the element locks."""
    element, ratio = element_of(body, material, cell), material.K / material.mu
    name = element if cell in SIMPLICES else "Q1"
    text = f"{name} {cell}s, K/mu = {ratio:.4g}"
    if element == "P1" and locks(material):
        remedy = (
            'element = "MINI"' if can_be_mini(material, cell) else "triangles of a built-in law"
        )
        return f"WARNING: {text}: too stiff near incompressibility; use {remedy}"
    return text
