"""Mesh builders and mesh files, by the name in a case."""

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.meshes.builder import Builder
from contactfem.meshes.cylinder import Cylinder
from contactfem.meshes.data import MeshData, Surface
from contactfem.meshes.die import Die
from contactfem.meshes.disk import Disk, Ring
from contactfem.meshes.extrusion import Extrusion
from contactfem.meshes.file import MeshFile
from contactfem.meshes.graded_block import GradedBlock
from contactfem.meshes.graded_box import GradedBox
from contactfem.meshes.revolution import Revolution
from contactfem.meshes.tire import Tire
from contactfem.meshes.wave import Wave

__all__ = ["BUILDERS", "Builder", "MeshData", "MeshFile", "MeshSpec", "Surface"]

BUILDERS = (
    "block", "box", "cylinder", "die", "disk", "extrusion", "graded_block", "graded_box",
    "revolution", "ring", "tire", "wave",
)  # fmt: skip


def _kind(mesh: Any) -> str | None:
    """Name of the model for a mesh table: that of its builder, or "file"."""
    if isinstance(mesh, dict):
        return "file" if "file" in mesh else mesh.get("builder")
    return getattr(mesh, "builder", "file")


MeshSpec = Annotated[
    Annotated[Block, Tag("block")]
    | Annotated[Box, Tag("box")]
    | Annotated[Cylinder, Tag("cylinder")]
    | Annotated[Die, Tag("die")]
    | Annotated[Disk, Tag("disk")]
    | Annotated[Extrusion, Tag("extrusion")]
    | Annotated[GradedBlock, Tag("graded_block")]
    | Annotated[GradedBox, Tag("graded_box")]
    | Annotated[Revolution, Tag("revolution")]
    | Annotated[Ring, Tag("ring")]
    | Annotated[Tire, Tag("tire")]
    | Annotated[Wave, Tag("wave")]
    | Annotated[MeshFile, Tag("file")],
    Discriminator(
        _kind,
        custom_error_type="mesh_builder",
        custom_error_message=f"must have 'file' or a 'builder', one of {', '.join(BUILDERS)}",
    ),
]
