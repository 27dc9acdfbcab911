"""Meshes over the ranks, degrees of freedom, seams to dolfinx and PETSc."""
