"""Batches: many paths, or the costs between many places, in one call."""
