"""Tracks of people: filters of their motion, assignment of detections, and a tracker of one sensor or robot."""
