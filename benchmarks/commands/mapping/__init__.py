"""Benches of mapping."""
