"""Planners from cell to cell of a grid, and their searches."""
