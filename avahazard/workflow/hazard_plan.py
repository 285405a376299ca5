"""What a run of `hazard` will take, from a short measurement on a few paths."""

from __future__ import annotations

import json
import shutil
import time
from statistics import mean
from typing import Any

import numpy as np

from avahazard.engine import chosen
from avahazard.engine.memory import free_bytes, peak_bytes
from avahazard.records.errors import AvahazardError
from avahazard.results.hazard import HazardPlan
from avahazard.store.results import interrupted_run
from avahazard.store.session import database_file, reading
from avahazard.workers import n_workers
from avahazard.workflow.hazard import hazard_work
from avahazard.workflow.requests import HazardRequest
from avahazard.workflow.stored.by_path import path_answer, path_tasks, run_key

MEASURED = 4
"""Paths that are measured, evenly over all; one more is run first, unmeasured."""


def plan_hazard(database: str, name: str, request: HazardRequest) -> HazardPlan:
    """Say what `run_hazard` will take with the same arguments; nothing is stored.

    Raises `AvahazardError` as that does, and where memory or disk will not do.
    """
    work, _ = hazard_work(database, name, request)
    path_ids = work.path_ids
    with reading(database) as session:
        key = run_key(work)
        _, done = interrupted_run(session, work.kind, name, key) or (0, set[str]())
    places = np.unique(np.linspace(0, len(path_ids) - 1, MEASURED).astype(int))
    tasks = list(path_tasks(database, work.survey, [path_ids[k] for k in places]))
    before = peak_bytes()
    shared = work.answer, work.survey.others
    path_answer(shared, tasks[0])
    seconds, sizes = [], []
    for task in tasks:
        began = time.perf_counter()
        found = path_answer(shared, task)
        seconds.append(time.perf_counter() - began)
        sizes.append(len(json.dumps(found.documents)))
    peak, workers, engine = peak_bytes(), n_workers(), chosen()
    elsewhere = engine.scheduler is not None
    memory = peak + (workers - 1) * (peak - before)
    if engine.name != "local":
        # Each process holds about what this one does.
        memory = peak * (1 if elsewhere else workers + 1)
    rows = max(1, len(work.settings["return_periods"]) + len(work.settings["volumes"]))
    file = database_file(database)
    n_left = len(path_ids) - len(done)
    plan = HazardPlan(
        n_paths=len(path_ids),
        n_done=len(done),
        n_rows=rows * len(path_ids),
        n_runs=rows * len(path_ids) * request.draws,
        engine=engine.name,
        workers=workers,
        measured_paths=len(tasks),
        seconds_per_path=mean(seconds),
        seconds=mean(seconds) * n_left / workers,
        memory_bytes=memory,
        memory_free_bytes=free_bytes(),
        stored_bytes=int(mean(sizes) * n_left),
        disk_free_bytes=None if file is None else shutil.disk_usage(file.parent).free,
    )
    _refuse(plan, peak)
    return plan


def _refuse(plan: HazardPlan, taken: int) -> None:
    """Raise `AvahazardError` for what cannot fit; `taken` bytes are this process's already."""
    needs: list[tuple[str, int, int | None, Any]] = [
        ("memory", plan.memory_bytes - taken, plan.memory_free_bytes, "Take fewer --workers."),
        ("disk", plan.stored_bytes, plan.disk_free_bytes, "Put the database elsewhere (--db)."),
    ]
    for what, need, free, hint in needs:
        if free is not None and need > free:
            raise AvahazardError(
                f"This needs about {need / 1e9:.2g} GB more of {what}, and {free / 1e9:.2g} GB are "
                "free.",
                hint,
            )
