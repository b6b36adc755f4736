"""Bench of planners: speed and correctness without a cloud, but for Fig. 3 of the paper."""
