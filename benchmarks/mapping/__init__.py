"""Mapping bench: recorded logs with true relations, and a simulated office with true poses."""
