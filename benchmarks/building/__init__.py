"""Benches of buildings: energy of fleets."""
