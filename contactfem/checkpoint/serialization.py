"""Frozen data of an interface as trees of arrays, and back."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from contactfem.checkpoint.archive import Tree
from contactfem.contact.conditions import relative_motion
from contactfem.contact.slip import Motion
from contactfem.contact.state import ContactHistory, ContactState, MortarOperators
from contactfem.laws.active_set import ActiveSet
from contactfem.laws.friction import FrictionBound

if TYPE_CHECKING:
    from contactfem.heat.interface import HeatExchange


def packed(item: Any) -> Tree:
    """Fields of a dataclass or a named tuple, and of those in it, as arrays.

    Args:
        item: With arrays, sparse matrices, numbers and None. Mortar operators are left out, and
            what they say about motion: their positions give them again.

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
        elif not (value is None or isinstance(value, MortarOperators | Motion)):
            tree[name] = packed(value)
    return tree


def history(tree: Tree) -> ContactHistory:
    """What a step starts from, of its tree."""
    return _unpacked(ContactHistory, tree)


def trial(tree: Tree) -> ActiveSet:
    """Contact status to start from, of its tree."""
    return _unpacked(ActiveSet, tree)


def conditions(tree: Tree, operators: MortarOperators) -> ContactState:
    """Contact conditions of their tree.

    Args:
        tree: From `packed`.
        operators: At the positions of the conditions.
    """
    limit = _unpacked(FrictionBound, tree["limit"])
    before = history(tree["history"])
    inner = {"operators": operators, "history": before, "limit": limit}
    inner["motion"] = relative_motion(operators, before)
    return _unpacked(ContactState, tree | inner)


def exchange(tree: Tree) -> HeatExchange:
    """What an interface adds to the heat problem, of its tree."""
    from contactfem.heat.interface import HeatExchange, NodalMeans

    return _unpacked(HeatExchange, tree | {"means": _unpacked(NodalMeans, tree["means"])})


def _unpacked[T](kind: type[T], tree: Tree) -> T:
    """A dataclass or a named tuple of its fields; those that are none of arrays as they are."""
    return kind(**{name: _value(part) for name, part in tree.items()})


def _value(part: Any) -> Any:
    if isinstance(part, dict):
        parts = (part["data"], part["indices"], part["indptr"])
        return sp.csr_matrix(parts, shape=tuple(part["shape"]))
    if isinstance(part, np.ndarray) and part.ndim == 0:
        return part.item()
    return part
