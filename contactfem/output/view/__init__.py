"""The fields of a run as a page, as pictures or in a window."""
