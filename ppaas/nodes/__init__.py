"""Nodes: capabilities with topics, services and parameters, each of which runs in the cloud or on the robot."""
