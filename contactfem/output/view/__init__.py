"""Look at the fields of a run: a page that turns, pictures, a window."""
