"""Where a run is computed: a device, and the number of threads of a processor."""

from dataclasses import dataclass

import warp as wp

from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.fields.checks import FROM_ONE, check_kind, check_known, check_whole


def device_names() -> list[str]:
    """Names of the devices of this machine: "cpu", and "cuda:0" and so on for GPUs."""
    return [str(device.alias) for device in wp.get_devices()]


@dataclass
class Execution:
    """Where a run is computed.

    The number of threads of a processor does not change any bit of the result. A GPU adds up sums
    in an order of its own.

    Attributes:
        device: "cpu", or the name that Warp gives to a GPU, for example "cuda:0".
        threads: threads of the processor, one of `mpm_warp.execution.THREAD_COUNTS`. The number may
            change while a run goes on. A GPU ignores it.

    Raises:
        SceneError: this machine has no such device, or the number of threads is not allowed.

    Example:
        >>> Execution(threads=2).device
        'cpu'
    """

    device: str = "cpu"
    threads: int = 1

    def __post_init__(self) -> None:
        check_kind("device", self.device, str)
        check_whole("threads", self.threads, FROM_ONE)
        check_known("device", self.device, device_names())
        check_known("threads", self.threads, THREAD_COUNTS)
