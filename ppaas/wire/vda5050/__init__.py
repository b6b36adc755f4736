"""VDA 5050 2.0, 2.1 and 3.0 without I/O: messages, topics, versions, and the state machine of an AGV.

Messages are structs with the names of 3.0; the codec spells them as in 2.x where the other side speaks it.

Source: VDA 5050, "Interface for the communication between automated guided vehicles (AGV) and a master control", and
its JSON schemas (https://github.com/VDA5050/VDA5050).
"""
