"""Kernels of perception."""
