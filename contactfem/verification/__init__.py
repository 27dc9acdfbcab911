"""Closed forms and manufactured solutions."""
