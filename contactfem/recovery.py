"""Superconvergent patch recovery: smooth stresses or fluxes from their values in the cells."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

RANK = 1e-3  # smallest singular value of samples that determine a polynomial, over the largest
LEVERAGE = 0.5  # largest variance of a recovered value over that of a sample; 1/n in a full patch
RINGS = 3  # how far away a vertex may look for a patch that is better than its own


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
        operator: Fits to the samples, shape (b n, m); term by term.
        mixing: What the polynomials take of them, shape (b k, b n); term by term.
    """

    vertices: Ints
    centres: Floats
    sizes: Floats
    compliance: Floats
    operator: sp.csr_matrix
    mixing: sp.csr_matrix

    def fit(self, samples: Floats) -> Floats:
        """Coefficients of all polynomials, by (33).

        Args:
            samples: Values at the centres of all cells of the mesh, shape (m, c).

        Returns:
            a, shape (k, b, c); `[:, 0]` are the values at the vertices.
        """
        k, n_terms = self.compliance.shape[:2]
        terms = (self.mixing @ (self.operator @ samples)).reshape(n_terms, k, samples.shape[1])
        return np.ascontiguousarray(terms.transpose(1, 0, 2))

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
    the mean of the polynomials of its nearest neighbours with better patches: around a vertex the
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
    fits = _fit(mesh, known)
    strong = np.zeros(len(points), np.bool_)
    strong[known] = fits.strong
    row, donor = _donors(mesh, chosen, strong)
    number = np.full(len(points), -1)
    number[known] = np.arange(len(known))
    return _mixed(points[chosen], chosen, fits, row, number[donor])


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

    def rows(self, vertices: Ints) -> sp.csr_matrix:
        """Sets of one vertex each."""
        k = len(vertices)
        return sp.csr_matrix((np.ones(k), vertices, np.arange(k + 1)), (k, len(self.points)))

    def grown(self, sets: sp.csr_matrix) -> sp.csr_matrix:
        """Sets of vertices with all that share a cell with one of them."""
        return ((sets @ self.incidence) @ self.incidence.T).tocsr()

    def near(self, vertices: Ints) -> Ints:
        """Vertices with all that they may take a polynomial from."""
        mask = np.zeros(len(self.points))
        mask[vertices] = 1.0
        for _ in range(RINGS):
            mask = np.sign(self.incidence @ (self.incidence.T @ mask))
        return np.flatnonzero(mask)


@dataclass(frozen=True)
class _Fits:
    """Fits to the cells around vertices, each by itself; `strong` ones may serve others too."""

    points: Floats
    sizes: Floats
    compliance: Floats
    strong: Bools
    operator: sp.csr_matrix


def _terms(offset: Floats, n_terms: int) -> Floats:
    p = np.ones((len(offset), n_terms))
    p[:, 1:3] = offset
    if n_terms == 4:
        p[:, 3] = offset[:, 0] * offset[:, 1]
    return p


def _fit(mesh: _Mesh, vertices: Ints) -> _Fits:
    around, points = mesh.incidence[vertices], mesh.points[vertices]
    n_terms, k = mesh.cells.shape[1], len(vertices)
    count = np.diff(around.indptr)
    vertex, cell = np.repeat(np.arange(k), count), around.indices
    offset = mesh.centres[cell] - points[vertex]
    square = np.bincount(vertex, np.einsum("pi,pi->p", offset, offset), k)
    sizes = np.sqrt(square / np.maximum(count, 1))
    p = _terms(offset / sizes[vertex, None], n_terms)
    total = sp.csr_matrix((np.ones(len(cell)), np.arange(len(cell)), around.indptr), (k, len(cell)))
    i, j = np.triu_indices(n_terms)
    gram = np.empty((k, n_terms, n_terms))
    gram[:, i, j] = gram[:, j, i] = total @ (p[:, i] * p[:, j])
    compliance, determined = _inverses(gram)
    weights = np.einsum("pij,pj->ip", compliance[vertex], p)
    starts = (around.indptr[:-1] + len(cell) * np.arange(n_terms)[:, None]).ravel()
    operator = sp.csr_matrix(
        (weights.ravel(), np.tile(cell, n_terms), np.append(starts, n_terms * len(cell))),
        (n_terms * k, len(mesh.cells)),
    )
    strong = determined & (compliance[:, 0, 0] <= LEVERAGE)
    return _Fits(points, sizes, compliance, strong, operator)


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


def _donors(mesh: _Mesh, chosen: Ints, strong: Bools) -> tuple[Ints, Ints]:
    """Pairs of an index into `chosen` and a vertex whose fit it takes: its own if it is strong."""
    own = np.flatnonzero(strong[chosen])
    rows, donors = [own], [chosen[own]]
    left = np.flatnonzero(~strong[chosen])
    sets = mesh.rows(chosen[left])
    for _ in range(RINGS):
        if not len(left):
            break
        sets = mesh.grown(sets)
        row, donor = sets.nonzero()
        good = strong[donor]
        rows.append(left[row[good]])
        donors.append(donor[good])
        still = np.setdiff1d(np.arange(len(left)), row[good])
        left, sets = left[still], sets[still]
    return np.concatenate((*rows, left)), np.concatenate((*donors, chosen[left]))


def _mixed(centres: Floats, chosen: Ints, fits: _Fits, row: Ints, donor: Ints) -> Patches:
    """Patches at `centres`: the mean of their donors' polynomials, written in their own terms."""
    k, n, n_terms = len(chosen), len(fits.points), fits.compliance.shape[1]
    share = 1.0 / np.bincount(row, minlength=k)[row]
    sizes = np.bincount(row, share * fits.sizes[donor], k).astype(np.float64)
    step = (centres[row] - fits.points[donor]) / fits.sizes[donor, None]
    T = _moved(step, sizes[row] / fits.sizes[donor], n_terms)
    mean = sp.csr_matrix((share, (row, np.arange(len(row)))), (k, len(row)))
    spread = T @ fits.compliance[donor] @ T.transpose(0, 2, 1)
    compliance = (mean @ spread.reshape(-1, n_terms**2)).reshape(k, n_terms, n_terms)
    i, j = np.nonzero(T.any(axis=0))
    entries = (row[:, None] + k * i, donor[:, None] + n * j)
    values = share[:, None] * T[:, i, j]
    mixing = sp.csr_matrix(
        (values.ravel(), (entries[0].ravel(), entries[1].ravel())), (n_terms * k, n_terms * n)
    )
    return Patches(chosen, centres, sizes, compliance, fits.operator, mixing)


def _moved(step: Floats, ratio: Floats, n_terms: int) -> Floats:
    """Matrices T of a' = T a, the coefficients of p a in terms of p(step + ratio (ξ, η))."""
    T = np.zeros((len(step), n_terms, n_terms))
    T[:, 0, 0] = 1.0
    T[:, 0, 1:3] = step
    T[:, 1, 1] = T[:, 2, 2] = ratio
    if n_terms == 4:
        T[:, 0, 3] = step[:, 0] * step[:, 1]
        T[:, 1, 3], T[:, 2, 3] = ratio * step[:, 1], ratio * step[:, 0]
        T[:, 3, 3] = ratio**2
    return T
