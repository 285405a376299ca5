"""What memory this process has taken, and what the machine has left."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

MEMINFO = Path("/proc/meminfo")
CGROUP = Path("/sys/fs/cgroup")
LIMIT, USED, STAT = CGROUP / "memory.max", CGROUP / "memory.current", CGROUP / "memory.stat"


def peak_bytes() -> int:
    """The most that this process has held so far; 0 where the system does not tell."""
    try:
        import resource  # noqa: PLC0415 (not on Windows)
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def free_bytes() -> int | None:
    """What may still be taken on this machine, or in this container; None where unknown."""
    found = []
    if MEMINFO.is_file():
        lines = MEMINFO.read_text(encoding="ascii").splitlines()
        found += [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable")]
    elif hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    # A container may have less; files that it has read count as used, and are given back.
    with suppress(OSError, ValueError, KeyError):
        stat = dict(line.split() for line in STAT.read_text(encoding="ascii").splitlines())
        used = int(USED.read_text()) - int(stat["inactive_file"]) - int(stat["active_file"])
        found.append(int(LIMIT.read_text()) - used)
    return min(found) if found else None
