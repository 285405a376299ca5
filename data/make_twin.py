"""Make the twin of the seven paths and 173 avalanches of Ancey (2005), table 1.

The records themselves were never published. True to the paper are, for each path, its name,
section, altitudes, number of events, range of volumes and (for two) years of the records, and one
law of friction for all (its Gibbs estimate). All else is made up: the shapes of the profiles, the
events, their dates.

Run from the root of the checkout: .venv/bin/python data/make_twin.py
"""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import date, timedelta
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.synth.dataset import Exponential, Settings, SitePlan
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_records

# The one of the first hundred whose 173 true frictions, few as they are, come nearest to
# the constants and the scatter of the law that they were drawn from.
SEED = 57
LAW = Exponential(a=0.519, n=3.36e-7)
SCATTER = 0.158
VOLUME_REL_SIGMA = 0.1

SPACING_M = 15.0

# First and last year of the records that table 1 prints. Dates are drawn over 1900 to 2003 first,
# and then brought into these years: so all else is what it was without them.
PRINTED_YEARS = {"gurraz": (1933, 1962), "scey": (1910, 1937)}

# name, section, top m, bottom m, events, smallest m3, largest m3, slopes at top and bottom,
# bend (middle and half width, shares of the length), steps (amplitude, number, phase),
# seen below m, records from
PATHS = (
    ("Saint Clément", "channelled", 2250, 400, 42, 3e3, 1.2e6, (0.85, 0.08), (0.31, 0.20),
     ((0.06, 1.5, 0.1), (0.05, 3.2, 0.4)), None, 1900),
    ("Gurraz", "open", 3650, 1450, 16, 7e3, 3e5, (0.85, 0.18), (0.30, 0.16),
     ((0.08, 2.1, 0.7),), 2300, 1905),
    ("Saugy", "channelled", 2300, 750, 19, 1.6e3, 1.58e5, (0.90, 0.18), (0.25, 0.20),
     ((0.05, 1.2, 0.3), (0.06, 2.6, 0.9)), None, 1900),
    ("Scey", "channelled", 2050, 960, 15, 1e3, 6e4, (1.00, 0.18), (0.25, 0.16),
     ((0.07, 1.8, 0.5),), None, 1902),
    ("Entremène", "channelled", 2230, 1000, 27, 3e3, 4.8e5, (1.00, 0.18), (0.25, 0.20),
     ((0.06, 2.4, 0.2),), None, 1900),
    ("Nants", "open", 2450, 1250, 27, 2e3, 2.5e5, (1.00, 0.185), (0.25, 0.20),
     ((0.05, 1.4, 0.6), (0.04, 3.0, 0.1)), 1850, 1900),
    ("Grand Chantey", "open", 2300, 1200, 27, 2e3, 2.7e5, (1.00, 0.145), (0.25, 0.25),
     ((0.07, 2.0, 0.9),), None, 1903),
)  # fmt: skip


def bent_profile(
    drop_m: float,
    top_m: float,
    slopes: tuple[float, float],
    bend: tuple[float, float],
    waves: tuple[tuple[float, float, float], ...],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Profile points x, y `[n_points]` in metres: straight, then bent, then straight.

    The slope falls from `slopes[0]` to `slopes[1]` as a tanh of the relative distance, with
    its middle and half width in `bend`; each wave (amplitude, number, phase) makes steps in
    the middle of the path. All of it is smooth enough for the polynomial of the paper,
    which does not follow a path that is curved at its ends.
    """
    t = np.linspace(0.0, 1.0, 4001)
    share = -np.tanh((t - bend[0]) / bend[1])
    share = (share - share[-1]) / (share[0] - share[-1])
    in_middle = np.clip((t - 0.12) / 0.1, 0.0, 1.0) * np.clip((0.9 - t) / 0.2, 0.0, 1.0)
    steps = sum((a * np.sin(2 * np.pi * (k * t + phase)) for a, k, phase in waves), np.zeros(4001))
    slope = (slopes[1] + (slopes[0] - slopes[1]) * share) * (1.0 + in_middle * steps)
    length = drop_m / float(np.trapezoid(slope, t))
    x = np.linspace(0.0, length, round(length / SPACING_M) + 1)
    at = np.interp(x / length, t, slope)
    fall = np.concatenate([[0.0], np.cumsum(0.5 * (at[1:] + at[:-1]) * np.diff(x))])
    return np.round(x, 1), np.round(top_m - fall, 3)


def make_sites() -> tuple[SitePlan, ...]:
    """The seven paths, each with the shape that was made up for it."""
    sites = []
    for name, section, top, bottom, n, low, high, slopes, bend, waves, below, since in PATHS:
        path_id = name.lower().replace(" ", "-").replace("é", "e").replace("è", "e")
        x, y = bent_profile(top - bottom, top, slopes, bend, waves)
        sites.append(
            SitePlan(
                path=Path(
                    path_id,
                    name=f"{name} (twin)",
                    location=f"twin of {name} in Ancey (2005); the shape is made up",
                    section=section,
                    release_elevation_m=float(round(top - 0.06 * (top - bottom))),
                    observed_from=since,
                    observed_to=2003,
                    observed_below_m=below,
                ),
                profile=Profile(path_id, x, y),
                n_events=n,
                volume_median_m3=(low * high) ** 0.5,
                volume_log_sd=1.3,
                volume_low_m3=low,
                volume_high_m3=high,
                pin_range=True,
                release_share=0.12,
            )
        )
    return tuple(sites)


def make_twin(seed: int = SEED) -> tuple[Records, dict[str, object]]:
    """Records of the twin and their truth."""
    settings = Settings(law=LAW, scatter=SCATTER, volume_rel_sigma=VOLUME_REL_SIGMA)
    sites = make_sites()
    records, truth = make_dataset(seed, settings=settings, sites=sites)
    ranges = {s.path.path_id: (s.volume_low_m3, s.volume_high_m3) for s in sites}
    true_volumes = [e["volume_m3"] for e in truth["events"]]  # type: ignore[attr-defined]
    drawn_in = {p.path_id: (p.observed_from or 0, p.observed_to or 0) for p in records.paths}
    events = tuple(
        _in_years(_in_print(event, true, *ranges[event.path_id or ""]), drawn_in)
        for event, true in zip(records.events, true_volumes, strict=True)
    )
    paths = tuple(
        replace(path, observed_from=years[0], observed_to=years[1])
        if (years := PRINTED_YEARS.get(path.path_id)) is not None
        else path
        for path in records.paths
    )
    return replace(records, paths=paths, events=events), truth


def _in_years(event: Event, drawn_in: dict[str, tuple[int, int]]) -> Event:
    """The event on the same day of a winter within the printed years of its path, in like order.

    Its error stays the one that it was drawn with.
    """
    path_id = event.path_id or ""
    if path_id not in PRINTED_YEARS:
        return event
    day = date.fromisoformat(event.date or "")
    # A winter is named by its January; its December belongs to the year before.
    winter = day.year + (day.month == 12)
    since_december = (day - date(winter - 1, 12, 1)).days
    (first, last), (start, end) = PRINTED_YEARS[path_id], drawn_in[path_id]
    squeezed = first + 1 + (winter - start - 1) * (last - first) // (end - start)
    return replace(event, date=(date(squeezed - 1, 12, 1) + timedelta(since_december)).isoformat())


def _in_print(event: Event, true_m3: float, low_m3: float, high_m3: float) -> Event:
    """The columns that the paper's records had; volumes within the printed range, both ends too."""
    recorded = float(f"{event.volume_m3:.2e}")
    if true_m3 in (low_m3, high_m3):
        recorded = true_m3
    return replace(
        event,
        volume_m3=min(max(recorded, low_m3), high_m3),
        deposit_length_m=None,
        deposit_width_m=None,
        deposit_thickness_m=None,
        covariates={},
    )


def write_twin(folder: FilePath) -> None:
    """Write paths.csv, profiles.csv, events.csv and truth.json."""
    records, truth = make_twin()
    write_records(folder, records)
    text = json.dumps({"twin": "made up, see README.md", **truth}, indent=1) + "\n"
    (folder / "truth.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write_twin(FilePath(__file__).parent)
