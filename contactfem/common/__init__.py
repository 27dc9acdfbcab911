"""Array types, units, tables over time, text, files and timers."""
