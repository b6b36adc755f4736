"""Protocol of Rapyuta, the RoboEarth Cloud Engine of 2013, without I/O: handshake, messages, binary parts, interfaces.

Source: ``rapyuta/rce``, its packages ``rce-comm`` and ``rce-core``, whose classes the modules name.
"""
