"""Linear map of nodal values from one mesh to another."""

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Floats


class LinearMap:
    """Applies a matrix to nodal values.

    Attributes:
        matrix: weights of the source's nodes at the target's, (n_target, n_source).
    """

    matrix: sp.csr_matrix

    def __call__(self, values: Floats) -> Floats:
        """Values at the target's nodes.

        Args:
            values: at the source's nodes, (n_source, c) or (n_source,).

        Returns:
            (n_target, c) or (n_target,).
        """
        return np.asarray(self.matrix @ values)
