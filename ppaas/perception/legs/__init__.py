"""Legs of people in laser scans."""
