"""Processes of a cloud, master and endpoints: their settings, their main functions, and their keeper."""
