"""Specifications shared by master, machines and containers: containers, sizes, settings, checkpoints, map layers."""
