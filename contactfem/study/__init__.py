"""Families of runs, observed orders, suites."""
