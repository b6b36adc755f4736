"""Bridge of VDA 5050: robots of the cloud as AGVs of a master control, and AGVs of others as robots of the cloud."""
