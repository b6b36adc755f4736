"""Recordings of clones: what is recorded, and MCAP files of it, written and read."""
