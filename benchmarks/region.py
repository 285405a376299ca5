"""A simulated region from its records to its hazard: time and peak memory of each command.

… -m benchmarks.region --paths 1000                                   prints a table
… -m benchmarks.region --paths 1000 --engine processes --workers 2    other engines
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import psutil

from benchmarks.study import table

PROGRAM = Path(sys.executable).with_name("avahazard")
LOOK_EVERY_S = 0.2
Step = tuple[str, str, str, str, str]


def main() -> None:
    """Run the commands in a folder that is removed afterwards, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--paths", type=int, default=1000)
    parser.add_argument("--events", type=int, help="default: ten a path")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engine", default="local")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    n_events = given.events or 10 * given.paths
    engine = f"--engine {given.engine}" + (f" --workers {given.workers}" if given.workers else "")
    commands = {
        "synth": f"synth world --paths {given.paths} --events {n_events} --seed {given.seed}",
        "init": "init",
        "import": "import world",
        "calibrate": f"calibrate m --chains 2 {engine}",
        "hazard": f"hazard m {engine}",
        "export": "export m -o region.csv",
    }
    with tempfile.TemporaryDirectory(prefix="avahazard-region-") as name:
        folder = Path(name)
        steps = [run(step, words, folder, given.paths) for step, words in commands.items()]
        size = (folder / "region.db").stat().st_size
    print(f"\n{given.paths} paths, {n_events} events, {os.cpu_count()} cores\n")
    print(table(("step", "s", "CPU s", "peak MB", "ms a path"), steps))
    print(f"\nThe database has {size / 1e6:.0f} MB at the end.")


def run(step: str, words: str, folder: Path, n_paths: int) -> Step:
    """A row: seconds and CPU seconds of a command, and the most it held in all its processes."""
    print(f"avahazard {words}", file=sys.stderr, flush=True)
    began, peak, cpu = time.perf_counter(), 0, {}
    with (folder / "out.txt").open("ab") as out:
        command = [PROGRAM, "--db", "region.db", *words.split()]
        process = psutil.Popen(command, cwd=folder, stdout=out)
        while process.poll() is None:
            held = 0
            for one in family(process):
                try:
                    held += one.memory_info().rss
                    times = one.cpu_times()
                    cpu[one.pid] = times.user + times.system
                except psutil.Error:  # it has ended meanwhile
                    continue
            peak = max(peak, held)
            time.sleep(LOOK_EVERY_S)
    seconds = time.perf_counter() - began
    if process.returncode != 0:
        raise SystemExit(f"avahazard {words} ended with status {process.returncode}")
    numbers = (seconds, sum(cpu.values()), peak / 1e6, 1000.0 * seconds / n_paths)
    return f"`{step}`", *(f"{v:.{d}f}" for v, d in zip(numbers, (1, 1, 0, 1), strict=True))


def family(process: psutil.Popen) -> list[psutil.Process]:
    """The process and its children."""
    try:
        return [process, *process.children(recursive=True)]
    except psutil.Error:
        return []


if __name__ == "__main__":
    main()
