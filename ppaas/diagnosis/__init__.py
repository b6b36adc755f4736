"""Diagnosis of a robot: observations of what it sends, and findings in words."""
