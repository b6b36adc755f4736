"""Tracks of the people that one robot sees, by all of its detectors."""
