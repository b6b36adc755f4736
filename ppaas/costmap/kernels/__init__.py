"""Compiled kernels over costmaps. Each module has a ``warm`` that calls all of its kernels once."""
