"""Reuse of stored plans in place of new ones, and estimates of planning times."""
