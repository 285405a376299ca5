"""Log likelihood of each event, and its derivatives in location and scatter of friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.term_kernels import event_terms_kernel
from avahazard.kernels import kernel


class EventTerms(NamedTuple):
    """Per event: log likelihood `value` `[n_events]` and its derivatives.

    `by_location`, `by_scatter` `[n_events, n_volumes]` are derivatives in m and log σ at each
    volume node; `curvature` `[n_events]` is the second derivative in a shift common to all m.
    """

    value: Floats
    by_location: Floats
    by_scatter: Floats
    curvature: Floats


def event_terms(
    nodes: Nodes,
    location: Floats,
    scatter: Floats,
    volume_weight: Floats,
    student: bool = False,
    keep: NDArray[np.bool_] | None = None,
) -> EventTerms:
    """log Σ_q h_q Σ_k w_k p(ν_k | m_q, σ_q) of each event, less the log chance to be seen.

    Tails of vague records are added (`Nodes`).
    `location` m and `scatter` σ > 0 `[n_events, n_volumes]` at the volume nodes with weights
    `volume_weight` h. Friction scatters normally about m, or with `student` as Student's t,
    a few records being grossly wrong (`wrong_records`).
    Terms of events not in `keep` `[n_events]` are 0.
    """
    keep = np.ones(len(location), dtype=np.bool_) if keep is None else keep
    return EventTerms(
        *event_terms_kernel(nodes, location, scatter, volume_weight, student, keep, True)
    )


def event_values(
    nodes: Nodes,
    location: Floats,
    scatter: Floats,
    volume_weight: Floats,
    student: bool = False,
    keep: NDArray[np.bool_] | None = None,
) -> Floats:
    """`EventTerms.value` alone `[n_events]` in less time; the last bit may be another."""
    keep = np.ones(len(location), dtype=np.bool_) if keep is None else keep
    terms = event_terms_kernel(nodes, location, scatter, volume_weight, student, keep, False)
    return np.asarray(terms[0])


def summed_terms(
    nodes: Nodes,
    volume_weight: Floats,
    student: bool,
    keep: NDArray[np.bool_] | None,
    locations: Floats,
    scatters: Floats,
) -> Floats:
    """Sums `[n]` of the events' log likelihoods at `[n, n_events, n_volumes]` of both."""
    keep = np.ones(locations.shape[1], dtype=np.bool_) if keep is None else keep
    return np.asarray(_sums(nodes, locations, scatters, volume_weight, student, keep))


@kernel
def _sums(nodes, locations, scatters, volume_weight, student, keep):  # type: ignore[no-untyped-def]
    result = np.empty(len(locations))
    slopes = bool(0)  # for a constant the called kernel would be compiled once more
    for j in range(len(locations)):
        value, _, _, _ = event_terms_kernel(
            nodes, locations[j], scatters[j], volume_weight, student, keep, slopes
        )
        result[j] = np.sum(value)
    return result
