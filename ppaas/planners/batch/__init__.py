"""Batch planning: many paths, or the cost matrix between many poses, in one call."""
