"""Faults of all kinds, at random, under driving robots: what was lost, what was said twice, what was left behind."""
