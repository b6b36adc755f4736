"""Mappings as bytes: files of a whole mapping, and rows of a log that grows with it."""
