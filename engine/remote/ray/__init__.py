"""Machines that are nodes of a Ray cluster, which tells what nodes there are and has an agent on each.

No message of a robot or of the master goes by Ray.
"""
