"""Configuration of Cyclone DDS by the environment variables of ROS 2 for the discovery of nodes.

================================  =====================================================================================
variable                          effect
================================  =====================================================================================
``ROS_LOCALHOST_ONLY=1``          this computer alone; the other two variables are ignored
``ROS_AUTOMATIC_DISCOVERY_RANGE`` ``SUBNET`` (the default): nodes that multicast reaches; ``LOCALHOST``: nodes on this
                                  computer; ``OFF``: none; ``SYSTEM_DEFAULT``: as Cyclone DDS does it, without peers
``ROS_STATIC_PEERS``              addresses, separated by ``;``, at which nodes are looked for besides
================================  =====================================================================================

Source: ``rcl/discovery_options.h`` of ``ros2/rcl``, and "Improved Dynamic Discovery" on docs.ros.org.
"""

import ipaddress
from collections.abc import Mapping, Sequence
from xml.sax.saxutils import quoteattr

from ppaas.errors import InvalidInput

RANGE, PEERS, LOCALHOST_ONLY = "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"
RANGES = ("SUBNET", "LOCALHOST", "SYSTEM_DEFAULT", "OFF")

_COMPATIBLE = "<Compatibility><IgnoreTypeInformation>1.15</IgnoreTypeInformation></Compatibility>"
"""1.15 is eProsima: without this no type with an array or a list matches Fast DDS 3 (Kilted and newer)."""

_LOOPBACK = '<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'


def cyclone_configuration(environment: Mapping[str, str]) -> str:
    """Return the configuration of Cyclone DDS (XML) that the variables ask for.

    Raises
    ------
    InvalidInput
        The range is ``OFF``, in which a bridge finds no robot, or is none of ROS.
    """
    wanted = environment.get(RANGE) or "SUBNET"
    peers = [peer for text in environment.get(PEERS, "").split(";") if (peer := text.strip())]
    if environment.get(LOCALHOST_ONLY) == "1":
        wanted, peers = "LOCALHOST", []
    if wanted not in RANGES:
        raise InvalidInput(f"{RANGE} must be one of {', '.join(RANGES)}, not {wanted!r}")
    if wanted == "OFF":
        raise InvalidInput(f"{RANGE}=OFF keeps the bridge from finding any robot: set SUBNET or LOCALHOST")
    if wanted == "LOCALHOST":
        # The loopback interface has no multicast; nodes of this computer are found by the ports of their participants.
        interfaces = "" if any(map(_is_remote, peers)) else _LOOPBACK
        general = f"<General>{interfaces}<AllowMulticast>false</AllowMulticast></General>"
        return _domain(general + _discovery(["localhost", *peers]))
    return _domain(_discovery(peers) if peers and wanted == "SUBNET" else "")


def _domain(content: str) -> str:
    return f"<CycloneDDS><Domain>{content}{_COMPATIBLE}</Domain></CycloneDDS>"


def _discovery(peers: Sequence[str]) -> str:
    listed = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in peers)
    index = "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    return f"<Discovery>{index}<Peers>{listed}</Peers></Discovery>"


def _is_remote(peer: str) -> bool:
    """Return whether a peer may be another computer: it is no loopback address."""
    try:
        return not ipaddress.ip_address(peer).is_loopback
    except ValueError:
        return peer != "localhost"
