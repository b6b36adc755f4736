"""Formats of graphs and layouts: read into graphs of routes, and written."""
