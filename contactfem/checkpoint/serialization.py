"""Frozen data of an interface as trees of arrays, and back."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from contactfem.checkpoint.archive import Tree
from contactfem.contact.conditions import Contact
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.laws.active_set import ActiveSet
from contactfem.mortar.mortar_operators import MortarOperators

if TYPE_CHECKING:
    from contactfem.heat.interface import HeatExchange

SPACE = 3  # components of a vector, at most


def packed(item: Any) -> Tree:
    """Fields of a dataclass or a named tuple, and of those in it, as arrays.

    Args:
        item: With arrays, sparse matrices, numbers and None.

    Returns:
        The tree.
    """
    names = [f.name for f in fields(item)] if is_dataclass(item) else item._fields
    tree: Tree = {}
    for name in names:
        value = getattr(item, name)
        if isinstance(value, np.ndarray | float):
            tree[name] = np.asarray(value)
        elif sp.issparse(value):
            parts = {"data": value.data, "indices": value.indices, "indptr": value.indptr}
            tree[name] = parts | {"shape": np.array(value.shape)}
        elif value is not None:
            tree[name] = packed(value)
    return tree


def packed_state(c: ContactState) -> Tree:
    """What a contact state follows from, beside the positions of the nodes.

    Args:
        c: The state.

    Returns:
        The tree.
    """
    return {
        "multiplier": c.multiplier.vector,
        "active_set": packed(c.active_set),
        "history": packed(c.history),
    }


def history(tree: Tree) -> ContactHistory:
    """What a step starts from, of its tree."""
    return _unpacked(ContactHistory, tree)


def active_set(tree: Tree) -> ActiveSet:
    """Active set, of its tree."""
    return _unpacked(ActiveSet, tree)


def contact_state(tree: Tree, contact: Contact, operators: MortarOperators) -> ContactState:
    """Contact state of its tree.

    Args:
        tree: From `packed_state`.
        contact: The interface.
        operators: At the positions of the state.
    """
    start = active_set(tree["active_set"])
    return contact.state(operators, tree["multiplier"], history(tree["history"]), start)


def exchange(tree: Tree) -> HeatExchange:
    """What an interface adds to the heat problem, of its tree."""
    from contactfem.heat.interface import HeatExchange, NodalMeans

    return _unpacked(HeatExchange, tree | {"means": _unpacked(NodalMeans, tree["means"])})


def check_lengths(tree: Tree, sparse: tuple[int, int], length: int) -> None:
    """Make sure that the arrays of an interface have its size.

    Args:
        tree: From `packed`.
        sparse: Shape of its sparse matrices.
        length: Of its arrays; positions are of all of its nodes, the columns of the matrices.

    Raises:
        ValueError: One has another.
    """
    for name, part in tree.items():
        if isinstance(part, dict) and "indptr" in part:
            if tuple(int(n) for n in part["shape"]) != sparse:
                raise ValueError(f"'{name}' is of another interface")
        elif isinstance(part, dict):
            check_lengths(part, sparse, length)
        elif (
            part.dtype.kind not in "biuf"
            or (part.ndim and len(part) not in (length, sparse[1]))
            or any(components > SPACE for components in part.shape[1:])
            or part.ndim > 2
        ):
            raise ValueError(f"'{name}' is of another interface")


def _unpacked[T](kind: type[T], tree: Tree) -> T:
    """A dataclass or a named tuple of its fields; those that are none of arrays as they are."""
    return kind(**{name: _value(part) for name, part in tree.items()})


def _value(part: Any) -> Any:
    if isinstance(part, dict):
        parts = (part["data"], part["indices"], part["indptr"])
        matrix = sp.csr_matrix(parts, shape=tuple(part["shape"]))
        matrix.check_format(full_check=True)  # indices out of range would not be noticed later
        return matrix
    if isinstance(part, np.ndarray) and part.ndim == 0:
        return part.item()
    return part
