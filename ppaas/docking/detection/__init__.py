"""Detectors of docks: plug-ins that find the face of a dock in what a robot senses."""
