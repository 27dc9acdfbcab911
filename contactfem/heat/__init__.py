"""Equations of heat, time schemes, heat through interfaces."""
