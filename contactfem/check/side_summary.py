"""Which side of interfaces is nonmortar, and whether it should be."""

from collections.abc import Iterator

from contactfem.case.scene import Interface
from contactfem.case.schema import Case
from contactfem.case.side_choice import FINER
from contactfem.geometry.side_comparison import Facets, size_ratio

STIFFER = 10.0  # modulus of a finer nonmortar side over the mortar one's that makes doubtful peaks


def chosen_sides(case: Case) -> Iterator[str]:
    """Interfaces whose nonmortar side the program chose, and why; needs no mesh."""
    for name, sides in case.interfaces.items():
        if sides.why:
            yield f"{name}: {sides.nonmortar} is nonmortar, since {sides.why}"


def stiff_and_fine(case: Case, interface: Interface, sides: tuple[Facets, Facets]) -> str:
    """Whether a much stiffer nonmortar side is finer, too: pressures are then too high.

    A rigid body with fine facets on an elastic one with coarse ones had pressures that were 4 % too
    high at the peak, and 23 % beside it. Of several materials the softest of the nonmortar and the
    stiffest of the mortar body count.

    Args:
        case: The case.
        interface: One of its interfaces, between bodies.
        sides: Its nonmortar and its mortar side.

    Returns:
        A sentence; empty if all is well.
    """
    moduli = [
        [case.materials[name].E for name in case.bodies[side.partition(".")[0]].all_materials]
        for side in (interface.nonmortar, interface.mortar)
    ]
    stiffer = min(moduli[0]) / max(moduli[1])
    if stiffer < STIFFER or (ratio := size_ratio(*sides)) < FINER:
        return ""
    return (
        f"{interface.nonmortar} is {stiffer:.3g} times as stiff as {interface.mortar}, whose "
        f"facets are {ratio:.2g} times as large: pressures will be too high; better with "
        f"{interface.mortar} as nonmortar"
    )
