"""Graphs of routes and layouts of other programs, as lanes, zones and stations of a map, and back."""
