"""Equations of mechanics with contact: condensed and saddle point."""
