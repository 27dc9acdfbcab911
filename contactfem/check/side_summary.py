"""Which side of interfaces is nonmortar, and whether it should be."""

from collections.abc import Iterator

from contactfem.case.scene import Interface
from contactfem.case.schema import Case
from contactfem.case.side_choice import FINER
from contactfem.geometry.side_comparison import Facets, size_ratio
from contactfem.meshes.data import Surface

STIFFER = 10.0  # modulus of a finer nonmortar side over the mortar one's that makes doubtful peaks


def chosen_sides(case: Case) -> Iterator[str]:
    """Interfaces whose nonmortar side the program chose, and why; needs no mesh."""
    for name, sides in case.interfaces.items():
        if sides.why:
            yield f"{name}: {sides.nonmortar} is nonmortar, since {sides.why}"


def stiff_and_fine(
    interface: Interface, surfaces: tuple[Surface, Surface], stiffer: float
) -> Iterator[str]:
    """Whether a much stiffer nonmortar side is finer, too: pressures are then too high.

    A rigid body with fine facets on an elastic one with coarse ones had pressures that were 4 % too
    high at the peak, and 23 % beside it.

    Args:
        interface: An interface between bodies.
        surfaces: Its nonmortar and its mortar side.
        stiffer: Young's modulus of the nonmortar side over that of the mortar side [-].
    """
    first, second = (Facets(side.X, side.facets) for side in surfaces)
    if stiffer >= STIFFER and (ratio := size_ratio(first, second)) >= FINER:
        yield (
            f"WARNING: {interface.nonmortar} is {stiffer:.3g} times as stiff as "
            f"{interface.mortar}, whose facets are {ratio:.2g} times as large: pressures will be "
            f"too high; better with {interface.mortar} as nonmortar"
        )
