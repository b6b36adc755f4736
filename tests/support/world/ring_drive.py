"""Simulated drive round a small ring of corridors, twice, with true poses; simulated once."""

from functools import cache

from benchmarks.mapping import small_worlds

ring_drive = cache(small_worlds.ring_drive)
