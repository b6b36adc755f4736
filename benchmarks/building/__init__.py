"""Benches of buildings."""
