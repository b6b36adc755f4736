"""Buckets of plans by where they begin and end: those between two places are found without looking at others."""

EDGE = 0.5
"""Edge of a bucket [m]: at a tolerance of a half of it, which is common, what is sought lies in 16 buckets at most."""

LARGEST_TOLERANCE = 1.0
"""Farthest that the end of a plan may be from where it is sought [m]: 625 buckets."""
