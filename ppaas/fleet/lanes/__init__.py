"""Cells of a fleet along lanes that were drawn by hand."""
