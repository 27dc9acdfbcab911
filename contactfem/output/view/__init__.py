"""The fields of a run: a page, pictures, a window."""
