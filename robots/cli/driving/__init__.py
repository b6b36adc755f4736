"""Driving a robot by hand from a terminal, or by lines of JSON."""
