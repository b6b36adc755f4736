"""Planners on the cells of a grid, and their searches."""
