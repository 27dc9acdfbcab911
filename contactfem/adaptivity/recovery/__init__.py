"""Patch recovery of fluxes and stresses, and indicators in time."""
