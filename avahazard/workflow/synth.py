"""Make a synthetic dataset with known effects, on disk."""

from pathlib import Path as FilePath
from typing import Any, cast

from avahazard.results.files import SyntheticDataset
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import refuse_full, write_dataset
from avahazard.workflow.requests import SynthRequest


def synthesise(folder: FilePath, request: SynthRequest) -> SyntheticDataset:
    """Write a synthetic dataset into `folder` and return its result; all effects have one strength.

    Raises `AvahazardError` where the folder is not empty, an effect is unknown, or nothing runs.
    """
    refuse_full(folder)
    effects = dict.fromkeys(request.effects, request.strength)
    settings = Settings(speeds=request.speeds)
    records, truth = make_dataset(request.seed, request.events, request.paths, effects, settings)
    files = write_dataset(folder, records, truth)
    return SyntheticDataset(
        folder=str(folder),
        files=tuple(str(file) for file in files),
        seed=request.seed,
        effects=cast(dict[str, Any], truth["effects"]),
        n_paths=len(records.paths),
        n_events=len(records.events),
        n_left_profile=sum(event.left_profile for event in records.events),
        n_speeds=len(records.speeds),
    )
