"""Benches of ``ppaas bench``: a module for each, named as it is on the command line."""
