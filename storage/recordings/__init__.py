"""Recordings of robots on a local disk: files of MCAP, and the segments of rings."""
