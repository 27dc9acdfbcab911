"""Reports of a run: text, tables and one HTML page."""
