"""Mortar contact with friction on FEniCSx, run from case files with units."""

from contactfem.common import mpi_first

__version__ = "0.1.0"

mpi_first.install()
