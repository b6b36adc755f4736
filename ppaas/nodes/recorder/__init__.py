"""Recorder of a clone: collects messages for the recorder of its machine."""
