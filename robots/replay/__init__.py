"""Replay of recordings: feeds a clone with what a robot sent, and compares what the clone says."""
