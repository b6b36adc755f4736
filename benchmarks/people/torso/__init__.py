"""Scenes for the torso detector, and its training."""
