"""Verbs of ``ppaas map`` for files of maps: their publication, imports from other programs, and exports."""
