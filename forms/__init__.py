"""Weak forms and free energies in UFL: no mesh, no linear algebra."""
