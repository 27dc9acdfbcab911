"""Factor of a matrix with its dense Schur complement, on one rank."""

from ctypes import POINTER, byref, c_double, c_int, c_void_p

import numpy as np

from petsc4py import PETSc

from contactfem.common.typing import Floats, Ints
from contactfem.fem.compat import petsc_library

ZERO_PIVOT = 71  # PETSC_ERR_MAT_LU_ZRPVT
HALVES = 26  # which half of a solve MUMPS does
BOTH, FORWARD = -1, 1
INVERTED = 2  # MatFactorSchurStatus: PETSc then multiplies with what stands in S's place
OPTIONS = {  # of MUMPS, by number
    6: 0,  # stiffness matrices have a good diagonal
    14: 60,  # per cent of memory beyond what the analysis foresees
}


class SchurFactor:
    """Factor of K = [[K_ii, K_ik], [K_ki, K_kk]] with S = K_kk - K_ki K_ii⁻¹ K_ik of the kept k.

    MUMPS finds S on its way at the price of a plain factor, and K itself may be singular.

    Args:
        K: Matrix on one rank. It may change its values, not its pattern, between `factorise`.
        kept: Unknowns k, ascending.
        symmetric: Whether K is symmetric: its factor is then half as large.

    Attributes:
        S: The Schur complement of the last `factorise`, (k, k).
    """

    def __init__(self, K: PETSc.Mat, kept: Ints, symmetric: bool) -> None:
        self.kept, self._K = kept, K
        K.setOption(PETSc.Mat.Option.SYMMETRIC, symmetric)
        self._ksp = ksp = PETSc.KSP().create(K.comm)
        ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = ksp.getPC()
        pc.setOperators(K, K)
        pc.setType(PETSc.PC.Type.CHOLESKY if symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        pc.setFactorSetUpSolverType()
        self._factor = pc.getFactorMatrix()
        for number, value in OPTIONS.items():
            self._factor.setMumpsIcntl(number, value)
        places = PETSc.IS().createGeneral(kept.astype(np.int32), comm=PETSc.COMM_SELF)
        _call("MatFactorSetSchurIS", c_void_p(self._factor.handle), c_void_p(places.handle))
        self._right, self._left = K.createVecs()
        self.S: Floats = np.zeros((len(kept), len(kept)))

    def factorise(self) -> None:
        """Factorise the present values of K.

        Raises:
            PETSc.Error: It could not be.
        """
        self._ksp.setOperators(self._K)  # else setUp does not look at its values again
        self._ksp.setUp()
        if self._ksp.getPC().getFailedReason():
            raise PETSc.Error(ZERO_PIVOT)
        factor, handle, status = c_void_p(self._factor.handle), c_void_p(), c_int()
        _call("MatFactorCreateSchurComplement", factor, byref(handle), byref(status))
        self.S = self._entries(handle).T.copy()  # stored by columns
        _call("MatDestroy", byref(handle))
        # With σ 1 in its place a solve ends with the condensed right-hand side over σ, which is of
        # the size of the other unknowns
        self._scale = float(np.abs(np.diagonal(self.S)).mean()) or 1.0
        _call("MatFactorGetSchurComplement", factor, byref(handle), byref(status))
        self._entries(handle)[:] = np.eye(len(self.kept)) / self._scale
        _call("MatFactorRestoreSchurComplement", factor, byref(handle), INVERTED)

    def _entries(self, dense: c_void_p) -> Floats:
        """Entries of a dense matrix of the size of S, where they are."""
        pointer = POINTER(c_double)()
        _call("MatDenseGetArray", dense, byref(pointer))
        entries = np.ctypeslib.as_array(pointer, self.S.shape)
        _call("MatDenseRestoreArray", dense, byref(pointer))
        return entries

    def condense(self, r: Floats) -> Floats:
        """Right-hand side of the kept unknowns, r_k - K_ki K_ii⁻¹ r_i; half a solve.

        Args:
            r: Right-hand side, (n,).

        Returns:
            Values at `kept`.
        """
        return np.asarray(self._scale * self._solve(r, FORWARD)[self.kept])

    def expand(self, r: Floats, condensed: Floats, x: Floats) -> Floats:
        """All unknowns from the kept ones: K_ii x_i = r_i - K_ik x_k.

        Args:
            r: Right-hand side, (n,).
            condensed: What `condense` gave for it.
            x: Kept unknowns x_k.

        Returns:
            x, (n,).
        """
        shifted = r.copy()
        shifted[self.kept] += self._scale * x - condensed
        return self._solve(shifted, BOTH)

    def _solve(self, r: Floats, halves: int) -> Floats:
        """x_k = (r_k - K_ki K_ii⁻¹ r_i) / σ, and with both halves x_i = K_ii⁻¹ (r_i - K_ik x_k)."""
        self._factor.setMumpsIcntl(HALVES, halves)
        self._right.array[:] = r
        self._ksp.solve(self._right, self._left)
        return np.array(self._left.array_r)


def _call(name: str, *arguments: object) -> None:
    """Call what petsc4py does not wrap.

    Raises:
        PETSc.Error: It failed.
    """
    error = getattr(petsc_library(), name)(*arguments)
    if error:
        raise PETSc.Error(error)
