"""Transforms between frames: planar and exact about time, or in space and only the newest."""
