"""Benches of planners: speed and correctness, without a cloud except for Fig. 3 of the paper."""
