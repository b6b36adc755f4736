"""Bridge of VDA 5050 the other way: AGVs of other makers as robots of the cloud."""
