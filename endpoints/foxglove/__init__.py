"""Viewers of Foxglove: each sees the robots of its user, and those that are shared with the user."""
