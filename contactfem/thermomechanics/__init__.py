"""The staggered step and what the two fields exchange."""
