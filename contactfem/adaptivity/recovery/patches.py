"""Superconvergent patch recovery of stresses and heat fluxes (33)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Bools, Floats, Ints

RANK = 1e-3  # smallest singular value of samples that determine a polynomial, over the largest
LEVERAGE = 0.5  # largest variance of a recovered value over that of a sample; 1/n in a full patch
RINGS = 3  # how far away a vertex may look for better patches than its own


@dataclass(frozen=True)
class Patches:
    """A polynomial τ* = p a at each of some vertices, as a matrix: it is linear in the samples.

    p = [1, ξ, η], for quadrilaterals [1, ξ, η, ξη], with ξ and η the distances from the vertex over
    the size of its patch.

    Attributes:
        vertices: The vertices, shape (k,).
        centres: Their positions [m], shape (k, 2).
        sizes: Sizes of their patches [m], shape (k,).
        compliance: (PᵀP)⁻¹ [-], shape (k, b, b); p (PᵀP)⁻¹ pᵀ is the variance of p a over that of
            a sample.
        operator: Coefficients from samples, term by term, shape (b k, m).
    """

    vertices: Ints
    centres: Floats
    sizes: Floats
    compliance: Floats
    operator: sp.csr_matrix

    def fit(self, samples: Floats) -> Floats:
        """Coefficients of all polynomials, by (33).

        Args:
            samples: Values at the centres of all cells of the mesh, shape (m, c).

        Returns:
            a, shape (k, b, c); `[:, 0]` are the values at the vertices.
        """
        k, n_terms = self.compliance.shape[:2]
        terms = (self.operator @ samples).reshape(n_terms, k, samples.shape[1])
        return np.ascontiguousarray(terms.transpose(1, 0, 2))

    def at(self, rows: Ints) -> "Patches":
        """Some of them.

        Args:
            rows: Indices into `vertices`, shape (j,).
        """
        k, n_terms = self.compliance.shape[:2]
        place = (rows + k * np.arange(n_terms)[:, None]).ravel()
        return Patches(
            self.vertices[rows],
            self.centres[rows],
            self.sizes[rows],
            self.compliance[rows],
            self.operator[place],
        )

    def basis(self, rows: Ints, x: Floats) -> Floats:
        """Terms p of some of the polynomials, each at a point of its own.

        Args:
            rows: Indices into `vertices`, shape (j,).
            x: Points [m], shape (j, 2).

        Returns:
            Terms, shape (j, b).
        """
        offset = (x - self.centres[rows]) / self.sizes[rows, None]
        return _terms(offset, self.compliance.shape[1])


def patches(points: Floats, cells: Ints, vertices: Ints | None = None) -> Patches:
    """Fit polynomials to samples at the centres of the cells around vertices, (33).

    The samples are taken at the superconvergent points, and each counts once. A vertex that its
    cells do not surround (on the boundary), or that too few or collinear samples are around, takes
    the patches of its nearest neighbours that are better off instead, together: around a vertex the
    errors of the cells cancel, in half a patch they do not. Where there are none, in a body of one
    layer of cells, it keeps its own or, undetermined, the mean of the samples around.

    Args:
        points: Vertices of the mesh [m], shape (n, 2).
        cells: Triangles or quadrilaterals (in dolfinx's order), shape (m, 3 or 4).
        vertices: The vertices that are wanted; all without. They do not affect one another.

    Returns:
        Their patches.
    """
    mesh = _Mesh(points, cells)
    everything: Ints = np.arange(len(points))
    chosen = everything if vertices is None else vertices
    known = everything if vertices is None else mesh.near(vertices)
    own = _fit(mesh, known, mesh.incidence[known])
    strong = np.zeros(len(points), np.bool_)
    strong[known] = own.determined & (own.compliance[:, 0, 0] <= LEVERAGE)
    weak = np.flatnonzero(~strong[chosen])
    donors = _donors(mesh, chosen[weak], strong)
    served = donors.getnnz(axis=1) > 0
    weak = weak[served]
    shared = _fit(mesh, chosen[weak], donors[served] @ mesh.incidence)
    rows = np.searchsorted(known, chosen)
    rows[weak] = len(known) + np.arange(len(weak))
    return _selected(own, shared, rows)


@dataclass(frozen=True)
class _Mesh:
    points: Floats
    cells: Ints

    @cached_property
    def incidence(self) -> sp.csr_matrix:
        """The cells around each vertex."""
        m, k = self.cells.shape
        entries = (self.cells.ravel(), np.repeat(np.arange(m), k))
        return sp.csr_matrix((np.ones(m * k), entries), (len(self.points), m))

    @cached_property
    def centres(self) -> Floats:
        """The superconvergent points of linear and bilinear elements, [m]."""
        centres: Floats = self.points[self.cells].mean(axis=1)
        return centres

    def near(self, vertices: Ints) -> Ints:
        """Vertices with all whose patches they may take."""
        mask = np.zeros(len(self.points))
        mask[vertices] = 1.0
        for _ in range(RINGS):
            mask = np.sign(self.incidence @ (self.incidence.T @ mask))
        return np.flatnonzero(mask)


@dataclass(frozen=True)
class _Fits(Patches):
    """Fits, each to samples of its own; `determined` where they determine the polynomial."""

    determined: Bools


def _fit(mesh: _Mesh, vertices: Ints, around: sp.csr_matrix) -> _Fits:
    """Fit to samples with weights: a row of `around` for each vertex."""
    points, k, n_terms = mesh.points[vertices], len(vertices), mesh.cells.shape[1]
    vertex, cell = np.repeat(np.arange(k), np.diff(around.indptr)), around.indices
    offset = mesh.centres[cell] - points[vertex]
    total = sp.csr_matrix((around.data, np.arange(len(cell)), around.indptr), (k, len(cell)))
    square = total @ np.einsum("pi,pi->p", offset, offset)
    sizes = np.sqrt(square / np.maximum(total @ np.ones(len(cell)), 1.0))
    p = _terms(offset / sizes[vertex, None], n_terms)
    i, j = np.triu_indices(n_terms)
    gram = np.empty((k, n_terms, n_terms))
    gram[:, i, j] = gram[:, j, i] = total @ (p[:, i] * p[:, j])
    compliance, determined = _inverses(gram)
    weights = around.data * np.einsum("pij,pj->ip", compliance[vertex], p)
    starts = (around.indptr[:-1] + len(cell) * np.arange(n_terms)[:, None]).ravel()
    operator = sp.csr_matrix(
        (weights.ravel(), np.tile(cell, n_terms), np.append(starts, n_terms * len(cell))),
        (n_terms * k, len(mesh.cells)),
    )
    return _Fits(vertices, points, sizes, compliance, operator, determined)


def _terms(offset: Floats, n_terms: int) -> Floats:
    p = np.ones((len(offset), n_terms))
    p[:, 1:3] = offset
    if n_terms == 4:
        p[:, 3] = offset[:, 0] * offset[:, 1]
    return p


def _inverses(gram: Floats) -> tuple[Floats, Bools]:
    """Inverses of PᵀP, and which P determine a polynomial; from the others take a constant.

    Quadrilaterals whose samples say nothing about ξη (a grid turned by 45 degrees) do without it.
    """
    determined = _regular(gram)
    result = np.zeros_like(gram)
    result[determined] = np.linalg.inv(gram[determined])
    left = np.flatnonzero(~determined)
    if gram.shape[1] == 4 and len(left):
        result[left, :3, :3], determined[left] = _inverses(gram[left, :3, :3])
    elif len(left):
        result[left, 0, 0] = 1.0 / np.maximum(gram[left, 0, 0], 1.0)
    return result, determined


def _regular(gram: Floats) -> Bools:
    """Whether λ_min > RANK² λ_max; det ≤ λ_min tr^(b-1) tells it of most without eigenvalues."""
    trace, least = np.trace(gram, axis1=1, axis2=2), RANK**2
    regular: Bools = np.linalg.det(gram) > least * trace ** gram.shape[1]
    values = np.linalg.eigvalsh(gram[~regular])
    regular[~regular] = values[:, 0] > least * values[:, -1]
    return regular


def _donors(mesh: _Mesh, weak: Ints, strong: Bools) -> sp.csr_matrix:
    """Shares of the nearest strong vertices of each weak one; rows are empty where there are none.

    Nearest by rings: those that share a cell with it, else those that share one with these.
    """
    n, rows, donors = len(strong), [], []
    left = np.arange(len(weak))
    sets = sp.csr_matrix((np.ones(len(weak)), weak, np.arange(len(weak) + 1)), (len(weak), n))
    for _ in range(RINGS):
        sets = ((sets @ mesh.incidence) @ mesh.incidence.T).tocsr()
        row, donor = sets.nonzero()
        good = strong[donor]
        rows.append(left[row[good]])
        donors.append(donor[good])
        still = np.setdiff1d(np.arange(len(left)), row[good])
        left, sets = left[still], sets[still]
    found, entries = np.concatenate(rows), np.concatenate(donors)
    share = 1.0 / np.bincount(found, minlength=len(weak))[found]
    return sp.csr_matrix((share, (found, entries)), (len(weak), n))


def _selected(own: _Fits, shared: _Fits, rows: Ints) -> Patches:
    """The fits `rows` of both sets, numbered one after the other."""
    n, m, n_terms = len(own.vertices), len(shared.vertices), own.compliance.shape[1]
    term = np.arange(n_terms)[:, None]
    place = np.where(rows < n, rows + n * term, rows - n + n_terms * n + m * term).ravel()
    return Patches(
        np.concatenate((own.vertices, shared.vertices))[rows],
        np.concatenate((own.centres, shared.centres))[rows],
        np.concatenate((own.sizes, shared.sizes))[rows],
        np.concatenate((own.compliance, shared.compliance))[rows],
        sp.vstack((own.operator, shared.operator)).tocsr()[place],
    )
