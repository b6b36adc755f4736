"""Coordinator of the robots that see people on a map: one identity for each person, a count, and who follows whom."""
