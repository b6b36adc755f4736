"""Stored plans: their records, encoding and reuse."""
