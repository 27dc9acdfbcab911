"""Rigid motions of a body, and those that its constraints leave free."""

import numpy as np

from contactfem.common.typing import Bools, Floats

RANK = 1e-6  # singular values below this share of the largest count as zero


def rigid_modes(points: Floats, center: Floats, size: float) -> Floats:
    """Displacements of the translations, then of the rotations by 1/size about a centre.

    In 2D u = (a - c (y - y0)/size, b + c (x - x0)/size); in 3D u = a + c x (x - x0)/size.

    Args:
        points: (n, dim) [m].
        center: centre of the rotations (dim,) [m].
        size: length that makes the rotations comparable with the translations [m].

    Returns:
        Displacements (n, dim, 3) in 2D, (n, dim, 6) in 3D, of unit coefficients.
    """
    n, dim = points.shape
    arm = (points - center) / size
    translations = np.broadcast_to(np.eye(dim), (n, dim, dim))
    if dim == 2:
        rotations = np.stack([-arm[:, 1], arm[:, 0]], axis=1)[:, :, None]
    else:
        rotations = np.cross(np.eye(3)[None], arm[:, None]).transpose(0, 2, 1)
    return np.concatenate([translations, rotations], axis=2)


def free_rigid_modes(
    points: Floats,
    prescribed: Bools,
    center: Floats,
    size: float,
    *,
    rotation_held: bool = False,
) -> Floats:
    """Rigid motions that move no prescribed component of any point.

    Args:
        points: points of the body with prescribed components (n, dim) [m]; may be empty.
        prescribed: which components are (n, dim).
        center: centre of the rotations (dim,) [m].
        size: length that makes the rotations comparable with the translations [m].
        rotation_held: whether something else bars every rotation, as a grip does.

    Returns:
        Orthonormal coefficients of `rigid_modes`, (k, 3) in 2D, (k, 6) in 3D: a row per motion.
    """
    dim = points.shape[1]
    modes = rigid_modes(points, center, size)
    rows = [modes[prescribed]]
    if rotation_held:
        rows.append(np.eye(modes.shape[2])[dim:])
    constraints = np.concatenate(rows)
    # the Gram matrix has the null space of the constraints, but stays small
    values, vectors = np.linalg.eigh(constraints.T @ constraints)
    free = values <= RANK**2 * max(float(values[-1]), 1.0)
    return np.asarray(vectors.T[free])


def name_modes(modes: Floats, center: Floats, size: float) -> list[str]:
    """Words for free motions: "x", "y", "z", "rotation about (0, 0) m".

    Args:
        modes: orthonormal coefficients (k, 3) or (k, 6), from `free_rigid_modes`.
        center: as given there (dim,) [m].
        size: as given there [m].

    Returns:
        One entry per motion.
    """
    dim = len(center)
    inside = np.linalg.norm(modes, axis=0) > 1.0 - 1e-6  # unit vectors that lie in the free space
    names = [axis for axis, free in zip("xyz"[:dim], inside[:dim], strict=True) if free]
    rest = len(modes) - len(names)
    if rest and dim == 2:
        names.append(_pivot(modes, center, size, anywhere=bool(names)))
    elif rest:
        names.append("1 rotation" if rest == 1 else f"{rest} rotations")
    return names


def _pivot(modes: Floats, center: Floats, size: float, *, anywhere: bool) -> str:
    """The rotation, with the point it is about unless translations are free as well."""
    a, b, c = modes[np.argmax(np.abs(modes[:, 2]))]
    if anywhere:
        return "rotation"
    about = center + np.array([-b, a]) * size / c
    about = np.where(np.abs(about) < 1e-9 * size, 0.0, about)
    return f"rotation about ({about[0]:.4g}, {about[1]:.4g}) m"
