"""Mortar contact with friction on FEniCSx, run from case files with units."""

__version__ = "0.1.0"
