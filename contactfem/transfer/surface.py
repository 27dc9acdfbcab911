"""Fields along the contact surface, from one mesh to the other (29)-(31)."""

import numpy as np
import scipy.sparse as sp

from contactfem.common.block_csr import block_rows
from contactfem.common.typing import Floats
from contactfem.geometry.closest_point import NearestFacets
from contactfem.meshes.data import Surface
from contactfem.transfer.linear_map import LinearMap
from contactfem.transfer.matching import check_near, identity, same_mesh
from contactfem.transfer.point_location import cell_sizes, simplices, surroundings


class SurfaceTransfer(LinearMap):
    """Nodal values along a surface, from each target node's nearest point on the source's facets.

    In the reference configuration, without communication, and the same on all ranks. The weights
    lie in [0, 1]: bounds are conserved (p >= 0 stays so), and constants; along straight sides that
    end at the same points linear fields as well. Totals are not: see `conserved`.

    Attributes:
        matrix: (n_target, n_source) in the surfaces' own numbering, with rows of the sum 1.
        farthest: Largest distance of a target node from the source's facets [m].
    """

    matrix: sp.csr_matrix
    farthest: float

    def __init__(self, source: Surface, target: Surface, name: str) -> None:
        """Build the matrix.

        Args:
            source: surface that has the values.
            target: the same surface of another mesh of the body.
            name: the surface's name, for errors.

        Raises:
            MeshError: a node is farther from the source than half a facet, the larger of those
                around it and the nearest one of the source.
        """
        self._source, self._target = source, target
        if same_mesh(source.X, source.facets, target.X, target.facets):
            self.matrix, self.farthest = identity(len(source.X)), 0.0
            return
        facets = simplices(source.facets)
        nearest, weights, distance = NearestFacets(source.X, facets).closest(target.X)
        size = surroundings(target.X, target.facets)[1]
        larger = np.maximum(size, cell_sizes(source.X, facets)[nearest])
        check_near(name, target.X, distance, larger)
        self.matrix = block_rows(weights[:, None], facets[nearest], len(source.X))
        self.farthest = float(distance.max())

    def conserved(self, density: Floats, weights: Floats, total: float) -> tuple[Floats, float]:
        """Density at the target's nodes with a given total, Σ w_K q_K = Q to round-off.

        The interpolated density, rescaled. A loaded patch that lies between the target's nodes, so
        that interpolation sees nothing of it, loads the nodes of the facets it lies on.

        Args:
            density: q at the source's nodes, not negative, (n_source,).
            weights: w at the target's nodes, such as ∫ N_K dΓ, positive, (n_target,).
            total: Q, not negative.

        Returns:
            Density at the target's nodes (n_target,), and the defect of the interpolated one (see
            `conserving`).

        Raises:
            ValueError: there is a total but no density.
        """
        values = self(density)
        if total == 0.0 or values.any():
            return conserving(values, weights, total)
        return conserving(self.spread(density) / weights, weights, total)[0], -1.0

    def spread(self, density: Floats) -> Floats:
        """Load the target's nodes with what lies on their facets, the transpose of interpolation.

        Args:
            density: at the source's nodes, (n_source,).

        Returns:
            Sum of the densities at a target node, each by its share of the facet (n_target,).
        """
        facets = simplices(self._target.facets)
        nearest, shares, _ = NearestFacets(self._target.X, facets).closest(self._source.X)
        loads = shares * density[:, None]
        found = np.bincount(facets[nearest].ravel(), loads.ravel(), len(self._target.X))
        return found.astype(np.float64)


def conserving(values: Floats, weights: Floats, total: float) -> tuple[Floats, float]:
    """Rescale a density such that Σ w_K q_K = Q.

    Args:
        values: q, of one sign, (n,).
        weights: w, positive, (n,).
        total: Q.

    Returns:
        The density, and its defect before that: (Σ w q - Q) / max(|Σ w q|, |Q|), from -1 where all
        was missing to 1 where nothing should have been.

    Raises:
        ValueError: Q is not 0 and the density has no total, or one of the other sign.
    """
    raw = float(weights @ values)
    if raw == total:
        return values, 0.0
    if total == 0.0:
        return np.zeros_like(values), 1.0
    if raw == 0.0 or (raw > 0.0) != (total > 0.0):
        raise ValueError(f"a density with the total {raw:g} cannot be scaled to {total:g}")
    return values * (total / raw), (raw - total) / max(abs(raw), abs(total))
