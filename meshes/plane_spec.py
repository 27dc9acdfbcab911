"""Plane mesh builders, by the name in a case."""

from typing import Annotated

from pydantic import Field

from contactfem.meshes.block import Block
from contactfem.meshes.cylinder import Cylinder
from contactfem.meshes.die import Die
from contactfem.meshes.disk import Disk, Ring
from contactfem.meshes.graded_block import GradedBlock
from contactfem.meshes.tire import Tire
from contactfem.meshes.wave import Wave

PlaneSpec = Annotated[
    Block | Cylinder | Die | Disk | GradedBlock | Ring | Tire | Wave,
    Field(discriminator="builder"),
]
