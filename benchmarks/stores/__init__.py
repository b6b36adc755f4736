"""Bench of the Path Plan Database as it fills."""
