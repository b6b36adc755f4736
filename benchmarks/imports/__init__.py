"""Bench of the imports of foreign files: time, report, and whether a robot then drives."""
