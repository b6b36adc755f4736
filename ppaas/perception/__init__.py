"""Perception: depth images as laser scans, and moving objects in laser scans."""
