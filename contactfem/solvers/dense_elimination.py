"""Elimination of some unknowns of a dense matrix."""

from dataclasses import dataclass

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


@dataclass(frozen=True)
class SchurComplement:
    """A dense matrix of some unknowns, and its number among those of a run.

    Attributes:
        values: The matrix, (n, n).
        number: Another one for every new matrix.
    """

    values: Floats
    number: int


@dataclass(frozen=True)
class Condensed:
    """A right-hand side without the unknowns that are eliminated.

    Attributes:
        left: Forces on those that are left, (left,).
        gone: S_ee⁻¹ r_e of the others.
    """

    left: Floats
    gone: Floats


class Elimination:
    """S with the unknowns that are not left eliminated: S_ll - S_le S_ee⁻¹ S_el.

    Args:
        S: Matrix of n unknowns.
        left: Unknowns that are left, ascending.

    Attributes:
        S: The smaller matrix, (left, left).
        left: Unknowns that are left.
        number: Their numbers in it, -1 for the others, (n,).
    """

    def __init__(self, S: SchurComplement, left: Ints) -> None:
        self._of, self.left, n = S.number, left, len(S.values)
        self.number = np.full(n, -1, np.int64)
        self.number[left] = np.arange(len(left))
        self._gone = gone = np.flatnonzero(self.number < 0)
        self.S = S.values[np.ix_(left, left)]
        self._factor: tuple[Floats, Ints] | None = None
        self._across = S.values[np.ix_(left, gone)]
        self._answer: Floats = np.empty((0, len(left)))
        if len(gone):
            from scipy.linalg import lu_factor, lu_solve

            self._factor = lu_factor(S.values[np.ix_(gone, gone)], check_finite=False)
            self._answer = lu_solve(self._factor, S.values[np.ix_(gone, left)], check_finite=False)
            self.S -= self._across @ self._answer

    def is_reusable(self, S: SchurComplement, used: Bools) -> bool:
        """Whether it is one of S that leaves some unknowns."""
        return self._of == S.number and bool((self.number[used] >= 0).all())

    def condense(self, forces: Floats, right: Floats) -> Condensed:
        """Forces on the unknowns that are left, f_l - S_le S_ee⁻¹ r_e.

        Args:
            forces: f, (n,).
            right: Right-hand side r, (n,).
        """
        result = forces[self.left]
        if self._factor is None:
            return Condensed(result, np.empty(0))
        from scipy.linalg import lu_solve

        gone = lu_solve(self._factor, right[self._gone], check_finite=False)
        return Condensed(result - self._across @ gone, gone)

    def expand(self, x: Floats, right: Condensed) -> Floats:
        """All unknowns, x_e = S_ee⁻¹ (r_e - S_el x_l).

        Args:
            x: Those that are left, (left,).
            right: What `condense` made of the right-hand side.
        """
        result = np.empty(len(self.number))
        result[self.left] = x
        if len(self._gone):
            result[self._gone] = right.gone - self._answer @ x
        return result
