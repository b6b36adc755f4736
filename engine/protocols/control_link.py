"""The control link: what passes between the master and the agent of a machine. The agent dials."""

import msgspec

from engine.protocols.robot_link import Refusal
from engine.specs.containers import ContainerSpec


class Carried(msgspec.Struct, frozen=True):
    """A container that runs on a machine whose master went away.

    Parameters
    ----------
    spec : ContainerSpec
        As it was ordered, without its checkpoint.
    cores : float
        The size that it has now.
    secret : str
        With which it says who it is on its links.
    pid : int
        Of its process.
    """

    spec: ContainerSpec
    cores: float
    secret: str
    pid: int


class Register(msgspec.Struct, tag="register"):
    """A machine joins, with what it carries since a master before this one.

    ``memory`` is in bytes, ``network`` what it can send and receive in a second, 0 where that is not known; ``labels``
    tell what it is like, and ``release`` of this program it runs.
    """

    machine: str
    secret: str
    pid: int
    cores: int
    memory: int
    labels: dict[str, str] = {}
    network: float = 0.0
    carries: tuple[Carried, ...] = ()
    release: str = ""


class ContainerLoad(msgspec.Struct, frozen=True):
    """What one container uses: CPU in cores, proportional set size in bytes."""

    container: str
    cpu: float
    pss: int


class Heartbeat(msgspec.Struct, tag="heartbeat"):
    """The machine lives: its load, in cores, and that of its containers.

    ``network_used`` is what it sent and received in a second [bytes]; ``round_trips`` are those to other machines, by
    their names [s].
    """

    cpu: float
    memory_used: int
    containers: list[ContainerLoad]
    network_used: float = 0.0
    round_trips: dict[str, float] = {}


class AgentBeat(msgspec.Struct, tag="beat"):
    """The agent lives; its load takes longer to measure the more containers there are."""


class Launched(msgspec.Struct, tag="launched"):
    """The process of a container runs; it is ready when it has dialled the robot link."""

    container: str
    pid: int


class LaunchFailed(msgspec.Struct, tag="launch_failed"):
    """A container could not be started."""

    container: str
    refusal: Refusal


class Exited(msgspec.Struct, tag="exited"):
    """The process of a container is gone; status as ``waitpid`` tells it, negative for a signal."""

    container: str
    status: int


FromAgent = Register | AgentBeat | Heartbeat | Launched | LaunchFailed | Exited


class StartContainer(msgspec.Struct, tag="start"):
    """Start a container, and let it dial this Unix socket; from another host it goes by the relay of its machine."""

    spec: ContainerSpec
    secret: str
    link: str


class ResizeContainer(msgspec.Struct, tag="resize"):
    """Hold a container to another size [cores] from now on; what does not run any more is left alone."""

    container: str
    cores: float


class StopContainer(msgspec.Struct, tag="stop"):
    """End a container, by force if it has not gone by itself after ``grace`` seconds."""

    container: str
    grace: float = 2.0


class Welcome(msgspec.Struct, tag="welcome"):
    """The machine is in: it acts for the cloud process of this name, and ends all that it carries but these."""

    cloud: str
    adopted: tuple[str, ...] = ()


class Dismissed(msgspec.Struct, tag="dismissed"):
    """The machine is to end all that it carries, now: the cloud ends in order, or does not want it."""


class BeatAcknowledged(msgspec.Struct, tag="heard"):
    """A beat of a machine of another host has come; each is answered, in turn."""


ToAgent = Welcome | StartContainer | StopContainer | ResizeContainer | BeatAcknowledged | Dismissed
