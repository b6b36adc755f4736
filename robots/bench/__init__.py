"""Measures what a user waits for, each beside its yardstick in the same run."""
