"""Transforms between frames: planar and interpolated in time, or in space and latest only."""
