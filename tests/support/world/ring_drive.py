"""Simulated drive round a small ring of corridors, twice, with true poses; simulated once."""

from functools import cache

from benchmarks.mapping import ring

ring_drive = cache(ring.ring_drive)
