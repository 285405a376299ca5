"""Holy's density on the twin's frictions: it predicts new records better than a histogram."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.inference.fitting.mode import likely_friction
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.apparent import choose_kappa, holy_density
from avahazard.inference.seeds import generator
from avahazard.records.reading import read_records

TWIN = Path(__file__).parents[3] / "data"


def _histogram_log_density(train: np.ndarray, new: np.ndarray) -> float:
    """The histogram is spared empty bins (half a count each) and reaches over all new values."""
    edges = np.histogram_bin_edges(train, "auto")
    width = edges[1] - edges[0]
    low = edges[0] - width * max(0, np.ceil((edges[0] - new.min()) / width))
    n_bins = int(np.ceil((max(edges[-1], new.max()) - low) / width - 1e-9)) + 1
    count = np.histogram(train, n_bins, (low, low + n_bins * width))[0] + 0.5
    place = ((new - low) / width).astype(int)
    return float(np.mean(np.log(count[place] / count.sum() / width)))


def test_it_beats_a_histogram_on_held_out_records() -> None:
    """Thirty random halvings of the twin's apparent frictions; a few go the other way."""
    observations = build_observations(read_records([TWIN]))
    nodes = assemble(observations, Specification(), {}).nodes.at(np.empty(0))
    friction = likely_friction(nodes, in_log=True)
    friction = friction[np.isfinite(friction)]
    assert len(friction) > 150
    gains = []
    for k in range(30):
        order = generator(1, "halves", k).permutation(len(friction))
        train, new = friction[order[::2]], friction[order[1::2]]
        density = holy_density(train, choose_kappa(train))
        gains.append(float(np.mean(np.log(density.pdf(new)))) - _histogram_log_density(train, new))
    assert np.mean(gains) > 0.0
    assert np.sum(np.array(gains) > 0.0) >= 20
