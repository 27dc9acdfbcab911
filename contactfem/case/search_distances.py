"""Search distances of an interface, unless a case gives them."""

import numpy as np

from contactfem.case.obstacles import Circle, Polyline, RigidObstacle
from contactfem.case.scene import Interface
from contactfem.common.typing import Floats
from contactfem.geometry.facets import facet_sizes
from contactfem.geometry.thickness import thickness
from contactfem.meshes.data import MeshData, Surface, boundary_facets

SELF = 0.5  # of its own thickness, behind a body that meets itself: the far side is no overlap


def outline_of(mesh: MeshData) -> Floats:
    """Ends of all facets around a body, walked with the body on the left [m], (b, 2, 2)."""
    return np.asarray(mesh.points[boundary_facets(mesh.cells, mesh.cell_type)])


def search_distances(
    interface: Interface, nonmortar: Surface, own: Floats, other: float | None
) -> tuple[float, Floats]:
    """Largest gap and overlap in which the sides of an interface find each other.

    A gap of any width is one. An overlap is at most as deep as the body is thick, if its far side
    belongs to the nonmortar surface, too: what lies behind that is not inside of the body. One face
    of a body may have passed the other side by as much as the thicker of the two.

    Args:
        interface: The interface; its `search_radius` counts for both.
        nonmortar: Its nonmortar surface, k facets.
        own: Outline of the nonmortar body [m], (b, 2, 2).
        other: Smallest thickness of the mortar side [m]; None where it is the same body.

    Returns:
        Largest gap [m], and largest overlap of every nonmortar facet [m], (k,).
    """
    count = len(nonmortar.facets)
    if interface.search_radius is not None:
        return interface.search_radius, np.full(count, interface.search_radius)
    middles, normals = _facets(nonmortar)
    length, facet = thickness(middles, normals, own)
    if other is None:
        return np.inf, SELF * length
    far = own[facet].mean(axis=1)
    ours = {tuple(middle) for middle in np.round(middles / _grain(own)).tolist()}
    on_surface = np.array([tuple(m) in ours for m in np.round(far / _grain(own)).tolist()])
    return np.inf, np.where(on_surface & (facet >= 0), length, np.maximum(length, other))


def side_thickness(side: Surface, outline: Floats) -> float:
    """Smallest thickness of a body behind one of its surfaces [m]."""
    return float(thickness(*_facets(side), outline)[0].min())


def obstacle_thickness(obstacle: RigidObstacle) -> float:
    """Smallest thickness of a rigid obstacle [m]; infinite for a half-plane or a hollow."""
    if isinstance(obstacle, Polyline):
        chain = obstacle.chain
        edge = np.diff(chain, axis=0)
        normals = np.column_stack((edge[:, 1], -edge[:, 0])) / np.hypot(*edge.T)[:, None]
        outline = np.stack((chain[:-1], chain[1:]), axis=1)
        return float(thickness(outline.mean(axis=1), normals, outline)[0].min())
    if isinstance(obstacle, Circle) and not obstacle.inside:
        return 2.0 * obstacle.radius
    return np.inf


def radius_in_space(nonmortar: Surface) -> float:
    """Default search radius in space [m]: a quarter of the surface's extent, or two facets."""
    extent = float(np.linalg.norm(np.ptp(nonmortar.X, axis=0)))
    return max(0.25 * extent, 2.0 * float(facet_sizes(nonmortar.X, nonmortar.facets).max()))


def _facets(surface: Surface) -> tuple[Floats, Floats]:
    """Middles and outward unit normals of facets, (k, 2) each."""
    ends = surface.X[surface.facets]
    edge = ends[:, 1] - ends[:, 0]
    normals = np.column_stack((edge[:, 1], -edge[:, 0])) / np.hypot(*edge.T)[:, None]
    return ends.mean(axis=1), normals


def _grain(outline: Floats) -> float:
    """Length below which two places are one [m]."""
    return 1e-9 * float(np.ptp(outline.reshape(-1, 2), axis=0).max())
