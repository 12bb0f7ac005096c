"""This machine: its cores, its memory, and its processes.

Most is asked of psutil. Only Linux tells the memory of a container and resets the peak of a
process, by files that may be missing.
"""

from pathlib import Path

import psutil

CONTAINER_LIMITS = (
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)
"""Files in which Linux states the memory of a container."""
PEAK, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
"""Files in which Linux states the peak memory of a process, and by which it forgets it."""


def stated_in(file: Path) -> str:
    """What the system states in a file; "" if there is none."""
    try:
        return file.read_text(encoding="utf-8")
    except OSError:
        return ""


def usable_cores() -> int:
    """Cores that this process may use; all cores unless the system allows fewer."""
    process = psutil.Process()
    if hasattr(process, "cpu_affinity"):
        return len(process.cpu_affinity())
    return psutil.cpu_count() or 1


def memory_of_machine() -> int:
    """Bytes of memory that this machine has, or the container in which this process runs."""
    limits = [stated_in(file).strip() for file in CONTAINER_LIMITS]
    whole: int = psutil.virtual_memory().total
    return min([whole, *(int(it) for it in limits if it.isdecimal())])


def reset_peak_memory() -> bool:
    """Let the peak memory count from now on; False where that is impossible, as outside Linux."""
    try:
        RESET.write_text("5", encoding="utf-8")
    except OSError:
        return False
    return True


def peak_memory() -> int:
    """Peak resident memory of this process [byte]; the present one if the system tells no peak."""
    for line in stated_in(PEAK).splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024
    memory = psutil.Process().memory_info()
    return int(getattr(memory, "peak_wset", memory.rss))
