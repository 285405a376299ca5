"""The parameters of a model: the order in which samplers see them, and what people read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.effect import Effect, Parameter
from avahazard.inference.laws import Law, law
from avahazard.inference.specification import Specification
from avahazard.inference.study import Study

Floats = NDArray[np.float64]

SCATTER_CENTRE = 0.15
"""Prior centre of the scatter of log friction: the paper's Gibbs fit has 0.158."""
PATH_SCATTER = 0.2
"""Scale of the half-normal prior of the spread between paths, on log friction."""
SPEED_SCATTER_M_S = 3.0
"""Prior centre of the model's own error of speed; its log has standard deviation 1."""
SPEED_GRID = tuple(float(v) for v in np.log([0.3, 0.6, 1.2, 2.0, 3.3, 5.5, 9.0, 15.0, 25.0]))


@dataclass(frozen=True, slots=True)
class Slot:
    """One coordinate: a normal prior cut to [low, high], and the grid if it shapes the tables."""

    name: str
    unit: str
    mean: float
    sd: float
    low: float = -np.inf
    high: float = np.inf
    grid: tuple[float, ...] = ()
    neutral: float = np.nan


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Coordinates `[n_slots]`: law, log scatter (and its slope), effects, path, speed.

    `places` maps an effect's key to its slots; `tables` are the slots that shape the tables.
    """

    law: Law
    slots: tuple[Slot, ...]
    scatter: int
    scatter_slope: int | None
    reference_volume: float
    path_scatter: int | None
    speed_scatter: int | None
    places: dict[str, slice]
    tables: tuple[int, ...]
    log_scatter: bool

    @property
    def low(self) -> Floats:
        """Lower bounds `[n_slots]`."""
        return np.array([s.low for s in self.slots])

    @property
    def high(self) -> Floats:
        """Upper bounds `[n_slots]`."""
        return np.array([s.high for s in self.slots])

    def log_prior(self, u: Floats) -> float:
        """Log density of the prior at coordinates u `[n_slots]`, up to a constant."""
        z = (u - self._mean) / self._sd
        value = -0.5 * float(z @ z)
        if self.path_scatter is not None:
            # Half-normal in τ, seen from log τ.
            log_tau = u[self.path_scatter]
            value += log_tau - 0.5 * (np.exp(log_tau) / PATH_SCATTER) ** 2
        return value

    @property
    def _mean(self) -> Floats:
        return np.array([s.mean for s in self.slots])

    @property
    def _sd(self) -> Floats:
        return np.array([s.sd for s in self.slots])

    def readable(self, u: Floats) -> dict[str, tuple[Floats, str]]:
        """Values and unit by name of coordinates u `[..., n_slots]` (contract, section 3)."""
        natural = self.law.to_natural(u[..., : len(self.law.coordinates)])
        result = {
            name: (natural[..., k], unit)
            for k, (name, unit) in enumerate(zip(self.law.names, self.law.units, strict=True))
        }
        result["sigma"] = (np.exp(u[..., self.scatter]), "" if self.log_scatter else "friction")
        if self.scatter_slope is not None:
            result["sigma_n"] = (u[..., self.scatter_slope] / self.reference_volume, "1/m3")
        for place in self.places.values():
            for k in range(place.start, place.stop):
                result[self.slots[k].name] = (u[..., k], self.slots[k].unit)
        if self.path_scatter is not None:
            result["path-effect.tau"] = (np.exp(u[..., self.path_scatter]), "")
        if self.speed_scatter is not None:
            result["speed_sigma"] = (np.exp(u[..., self.speed_scatter]), "m/s")
        return result


def build_layout(specification: Specification, effects: tuple[Effect, ...], study: Study) -> Layout:
    """The coordinates of a model on a study; effects set their ranges by the data."""
    chosen = law(specification.law)
    slots = [
        Slot(name, "", float(mean), float(sd))
        for name, mean, sd in zip(
            chosen.coordinates, chosen.prior_mean, chosen.prior_sd, strict=True
        )
    ]
    log_scatter = specification.distribution == "lognormal"
    centre = SCATTER_CENTRE if log_scatter else 0.5 * SCATTER_CENTRE
    scatter = len(slots)
    slots.append(Slot("log sigma", "", float(np.log(centre)), 1.0, float(np.log(1e-3)), 2.0))
    slope = None
    if specification.scatter == "volume":
        slope = len(slots)
        slots.append(Slot("sigma_n", "", 0.0, 1.0))
    places: dict[str, slice] = {}
    path_scatter = None
    for effect in effects:
        if effect.groups is not None:
            path_scatter = len(slots)
            slots.append(Slot("log tau", "", 0.0, 1e3, float(np.log(1e-3)), 1.0))
            continue
        places[effect.key] = slice(len(slots), len(slots) + len(effect.parameters))
        slots += [_slot(effect, p) for p in effect.parameters]
    tables = tuple(k for k, s in enumerate(slots) if s.grid)
    speed_scatter = None
    if study.speeds:
        speed_scatter = len(slots)
        slots.append(
            Slot(
                "log speed sigma",
                "",
                float(np.log(SPEED_SCATTER_M_S)),
                1.0,
                SPEED_GRID[0],
                SPEED_GRID[-1],
                SPEED_GRID,
            )
        )
    volumes = np.exp(study.volumes.log_volume[:, study.volumes.log_volume.shape[1] // 2])
    return Layout(
        law=chosen,
        slots=tuple(slots),
        scatter=scatter,
        scatter_slope=slope,
        reference_volume=float(np.quantile(volumes, 0.9)),
        path_scatter=path_scatter,
        speed_scatter=speed_scatter,
        places=places,
        tables=tables,
        log_scatter=log_scatter,
    )


def _slot(effect: Effect, p: Parameter) -> Slot:
    name = effect.key if p.name == "" else f"{effect.key}.{p.name}"
    return Slot(name, p.unit, p.prior_mean, p.prior_sd, p.low, p.high, p.grid, p.neutral)
