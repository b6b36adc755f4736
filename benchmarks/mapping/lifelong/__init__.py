"""Drives through one place again and again, and the memory that its map takes."""
