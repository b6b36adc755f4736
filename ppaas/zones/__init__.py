"""Zones of a map: where robots keep out, drive slowly or one way, do not stop, or are few at a time."""
