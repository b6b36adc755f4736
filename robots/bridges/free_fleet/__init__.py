"""Robots of the cloud for free_fleet of Open-RMF, which takes robots with Navigation2 over Zenoh."""
