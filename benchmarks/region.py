"""A made-up region from its records to its bounds: time and peak memory of each step.

… benchmarks/region.py --paths 1000                     prints a table
… benchmarks/region.py --paths 1000 --engine processes  other engines
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import psutil

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
PROGRAM = Path(sys.executable).with_name("avahazard")
LOOK_EVERY_S = 0.2


@dataclass(frozen=True, slots=True)
class Step:
    """A command that ran: its time (s), CPU time, and the most it held in all its processes."""

    name: str
    seconds: float
    cpu_seconds: float
    peak_mb: float


def main() -> None:
    """Run the steps in a folder that is removed afterwards, and print the table."""
    given = arguments()
    with tempfile.TemporaryDirectory(prefix="avahazard-region-") as temporary:
        folder = Path(temporary) if given.folder is None else given.folder
        folder.mkdir(parents=True, exist_ok=True)
        steps = [run(name, words, folder) for name, words in commands(given)]
        size = (folder / "region.db").stat().st_size
    print(f"\n{given.paths} paths, {given.events} events, {os.cpu_count()} cores\n")
    print("| step | s | CPU s | peak MB | ms a path |\n|---|---|---|---|---|")
    for step in steps:
        print(
            f"| `{step.name}` | {step.seconds:.1f} | {step.cpu_seconds:.1f} | {step.peak_mb:.0f} "
            f"| {1000.0 * step.seconds / given.paths:.1f} |"
        )
    print(f"\nThe database has {size / 1e6:.0f} MB at the end.")


def commands(given: argparse.Namespace) -> list[tuple[str, list[str]]]:
    """The commands, in turn."""
    engine = ["--engine", given.engine]
    if given.workers is not None:
        engine += ["--workers", str(given.workers)]
    made = ["--paths", str(given.paths), "--events", str(given.events), "--seed", str(given.seed)]
    return [
        ("synth", ["synth", "world", *made]),
        ("init", ["init"]),
        ("import", ["import", "world"]),
        ("calibrate", ["calibrate", "m", "--chains", "2", *engine]),
        ("hazard --dry-run", ["hazard", "m", "--dry-run", *engine]),
        ("hazard", ["hazard", "m", *engine]),
        ("export", ["export", "m", "-o", "region.parquet"]),
    ]


def run(name: str, words: list[str], folder: Path) -> Step:
    """Run a command of the program in a folder, and watch it."""
    print(f"avahazard {' '.join(words)}", file=sys.stderr, flush=True)
    began = time.perf_counter()
    with (folder / "out.txt").open("ab") as out:
        process = psutil.Popen([PROGRAM, "--db", "region.db", *words], cwd=folder, stdout=out)
        watch = Watch(process)
        watch.start()
        status = process.wait()
    seconds = time.perf_counter() - began
    watch.join()
    if status != 0:
        raise SystemExit(f"avahazard {' '.join(words)} ended with status {status}")
    return Step(name, seconds, watch.cpu_seconds, watch.peak / 1e6)


class Watch(threading.Thread):
    """Looks at a process and its children as long as it runs; `peak` in bytes."""

    def __init__(self, process: psutil.Popen) -> None:
        super().__init__(daemon=True)
        self.process = process
        self.peak, self.cpu_seconds = 0, 0.0
        self.cpu: dict[int, float] = {}

    def run(self) -> None:
        """Look now and then until the process has ended."""
        while self.process.poll() is None:
            held = 0
            for one in self.family():
                try:
                    held += one.memory_info().rss
                    times = one.cpu_times()
                    self.cpu[one.pid] = times.user + times.system
                except psutil.Error:  # it has ended meanwhile
                    continue
            self.peak = max(self.peak, held)
            self.cpu_seconds = sum(self.cpu.values())
            time.sleep(LOOK_EVERY_S)

    def family(self) -> list[psutil.Process]:
        """The process and its children."""
        try:
            return [self.process, *self.process.children(recursive=True)]
        except psutil.Error:
            return []


def arguments() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description="A region from its records to its bounds.")
    parser.add_argument("--paths", type=int, default=1000)
    parser.add_argument("--events", type=int, help="default: ten a path")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engine", default="local")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--folder", type=Path, help="keep what is made here")
    given = parser.parse_args()
    given.events = given.events or 10 * given.paths
    return given


if __name__ == "__main__":
    main()
