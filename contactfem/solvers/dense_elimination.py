"""Elimination of some unknowns of a dense matrix."""

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints


def solve(A: Floats, b: Floats) -> Floats:
    """Solve A x = b; A is overwritten.

    Args:
        A: Matrix, (n, n), stored by rows.
        b: Right-hand side, (n,).

    Raises:
        LinAlgError: A is singular.
    """
    from scipy.linalg.lapack import dgetrf, dgetrs

    if len(b) == 0:  # contact touches nothing, and LAPACK refuses nothing
        return np.empty(0)
    # LAPACK stores by columns and so finds the transpose in place: it factorises that
    lu, pivots, info = dgetrf(A.T, overwrite_a=True)
    if info:
        raise np.linalg.LinAlgError(f"pivot {info} is zero")
    return np.asarray(dgetrs(lu, pivots, b, trans=1)[0])


class Elimination:
    """S with the unknowns that are not left eliminated: S_ll - S_le S_ee⁻¹ S_el.

    Args:
        S: Matrix, (n, n).
        left: Unknowns that are left, ascending.

    Attributes:
        S: The smaller matrix, (left, left).
        left: Unknowns that are left.
        number: Their numbers in it, -1 for the others, (n,).
    """

    def __init__(self, S: Floats, left: Ints) -> None:
        self._from, self.left, n = S, left, len(S)
        self.number = np.full(n, -1, np.int64)
        self.number[left] = np.arange(len(left))
        self._gone = np.flatnonzero(self.number < 0)
        self.S = S[np.ix_(left, left)]
        if len(self._gone):
            from scipy.linalg import lu_factor, lu_solve

            self._factor = lu_factor(S[np.ix_(self._gone, self._gone)], check_finite=False)
            across = S[np.ix_(self._gone, left)]
            self._answer = lu_solve(self._factor, across, check_finite=False)
            self._across = S[np.ix_(left, self._gone)]
            self.S -= self._across @ self._answer

    def serves(self, S: Floats, used: Bools) -> bool:
        """Whether it is one of S that leaves some unknowns."""
        return self._from is S and bool((self.number[used] >= 0).all())

    def condense(self, forces: Floats, right: Floats) -> Floats:
        """Forces on the unknowns that are left, f_l - S_le S_ee⁻¹ r_e.

        Args:
            forces: f, (n,).
            right: Right-hand side r, (n,), kept for `expand`.
        """
        result = forces[self.left]
        if len(self._gone):
            from scipy.linalg import lu_solve

            self._alone = lu_solve(self._factor, right[self._gone], check_finite=False)
            result = result - self._across @ self._alone
        return result

    def expand(self, x: Floats) -> Floats:
        """All unknowns, x_e = S_ee⁻¹ (r_e - S_el x_l).

        Args:
            x: Those that are left, (left,).
        """
        result = np.empty(len(self.number))
        result[self.left] = x
        if len(self._gone):
            result[self._gone] = self._alone - self._answer @ x
        return result
