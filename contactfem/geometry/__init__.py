"""Boxes, closest points, areas and sizes of cells, rigid motions."""
