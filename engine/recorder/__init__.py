"""Recorder of a machine: the process that writes the recordings and rings of the robots whose containers run there."""
