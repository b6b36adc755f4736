"""Simulated depth camera, and the shapes that it sees."""
