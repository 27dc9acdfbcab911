"""Named geometries and mesh files: what a body's `mesh` may say in a case file."""

from contactfem.meshes.block import Block
from contactfem.meshes.data import MeshData, Surface

MeshSpec = Block

__all__ = ["Block", "MeshData", "MeshSpec", "Surface"]
