"""Lifelong mapping: key frames bounded by the area, and things that moved away leave the map."""
