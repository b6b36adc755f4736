"""Control link: messages between the master and the agent of a machine. The agent dials."""

import msgspec

from engine.protocols.refusals import Refusal
from engine.protocols.versions import UNSTATED, Protocols
from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.start_state import KernelProgress


class RunningContainer(msgspec.Struct, frozen=True):
    """A container that runs on a machine whose master has exited.

    Parameters
    ----------
    spec : ContainerSpec
        Its spec, without the checkpoint.
    cores : float
        Its current size [CPU cores].
    secret : str
        Secret with which it authenticates on its links.
    pid : int
        Its process id.
    """

    spec: ContainerSpec
    cores: float
    secret: str
    pid: int


class Register(msgspec.Struct, tag="register"):
    """A machine joins, with the containers that it still runs for an earlier master.

    ``memory`` is in bytes. ``network`` is the bandwidth in bytes per second, 0 if unknown. ``labels`` describe the
    machine; ``release`` is the release of this program that it runs. ``epoch`` is the epoch of the latest master that
    it has followed, 0 if it has followed none: a master of an earlier epoch was replaced. ``protocols`` are the ones
    that it speaks.
    """

    machine: str
    secret: str
    pid: int
    cores: int
    memory: int
    labels: dict[str, str] = {}
    network: float = 0.0
    carries: tuple[RunningContainer, ...] = ()
    release: str = ""
    epoch: int = 0
    protocols: Protocols | None = None


class MachineStarting(msgspec.Struct, tag="starting"):
    """A machine that is about to join cannot start containers yet. Sent repeatedly on a separate connection.

    ``kernels`` is the progress of its kernel compiler, None if that is not known yet.
    """

    machine: str
    secret: str
    kernels: KernelProgress | None = None


class ContainerLoad(msgspec.Struct, frozen=True):
    """Load of one container: CPU usage [cores] and proportional set size [bytes]."""

    container: str
    cpu: float
    pss: int


class Heartbeat(msgspec.Struct, tag="heartbeat"):
    """Load report of a machine and its containers.

    ``cpu`` is in cores, ``memory_used`` in bytes, ``network_used`` the traffic in both directions [bytes/s].
    ``round_trips`` are the round-trip times to other machines, by name [s]. ``work`` is what its containers have done
    since the agent started (``engine.specs.work_counts``).
    """

    cpu: float
    memory_used: int
    containers: list[ContainerLoad]
    network_used: float = 0.0
    round_trips: dict[str, float] = {}
    work: dict[str, int] = {}


class AgentBeat(msgspec.Struct, tag="beat"):
    """Heartbeat of the agent. It is separate from the load report, which takes longer with many containers.

    Parameters
    ----------
    compiling : tuple of str
        Containers that compile a kernel themselves and may therefore send no heartbeats.
    kernels : KernelProgress, optional
        Progress of the kernel compiler of the machine; None if all kernels are compiled.
    """

    compiling: tuple[str, ...] = ()
    kernels: KernelProgress | None = None


class Launched(msgspec.Struct, tag="launched"):
    """The process of a container runs. The container is ready when it has dialled the robot link."""

    container: str
    pid: int


class LaunchFailed(msgspec.Struct, tag="launch_failed"):
    """A container could not be started."""

    container: str
    refusal: Refusal


class Exited(msgspec.Struct, tag="exited"):
    """The process of a container has exited; ``status`` is negative for a signal."""

    container: str
    status: int


class Outranked(msgspec.Struct, tag="outranked"):
    """The machine refuses this master, since it has followed one of a later epoch, and disconnects."""

    epoch: int


FromAgent = Register | MachineStarting | AgentBeat | Heartbeat | Launched | LaunchFailed | Exited | Outranked


class StartContainer(msgspec.Struct, tag="start"):
    """Start a container, which dials the Unix socket ``link``. On another host, its machine relays that connection."""

    spec: ContainerSpec
    secret: str
    link: str


class ResizeContainer(msgspec.Struct, tag="resize"):
    """Resize a container to this number of cores. Ignored if it does not run."""

    container: str
    cores: float


class UseMapVersions(msgspec.Struct, tag="use_map"):
    """Move the clone in a container to other versions of its map and masks. Ignored if it does not run.

    The fields replace the ones in its spec and its robot from now on.
    """

    container: str
    map: MapVersion
    masks: dict[str, MapVersion]
    in_space: bool


class StopContainer(msgspec.Struct, tag="stop"):
    """Stop a container; kill it if it has not exited by itself after ``grace`` [s]."""

    container: str
    grace: float = 2.0


class Welcome(msgspec.Struct, tag="welcome"):
    """The machine is registered with the cloud process ``cloud``, and stops all containers except the adopted ones.

    All orders on this connection are of the epoch ``epoch`` of the master, and of the version ``protocol``.
    """

    cloud: str
    adopted: tuple[str, ...] = ()
    epoch: int = 0
    protocol: int = UNSTATED.newest


class Dismissed(msgspec.Struct, tag="dismissed"):
    """The machine must stop all its containers now: the cloud shuts down, or refuses the machine."""


class BeatAcknowledged(msgspec.Struct, tag="heard"):
    """Acknowledges one heartbeat of a machine, in order.

    ``leads`` is false while the master does not know that it leads: the machine stays, and does not act for the cloud.
    """

    leads: bool = True


class MastersChanged(msgspec.Struct, tag="masters"):
    """Addresses of the processes that may lead the cloud, in place of those that the machine knows."""

    masters: tuple[str, ...]


ToAgent = (
    Welcome
    | StartContainer
    | StopContainer
    | ResizeContainer
    | UseMapVersions
    | BeatAcknowledged
    | MastersChanged
    | Dismissed
)
