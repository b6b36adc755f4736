"""Graphs of routes, independent of the format of their file, and what becomes of their parts."""
