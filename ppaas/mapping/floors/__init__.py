"""Drives over several floors, as one map a floor: floors by heights, scans by floors, and where the maps join."""
