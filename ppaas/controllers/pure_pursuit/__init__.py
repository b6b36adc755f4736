"""Regulated pure pursuit: steers towards a point ahead on the path."""
