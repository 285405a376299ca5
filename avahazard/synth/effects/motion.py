"""Effects on the motion: what else than constant friction resists the block.

Where an effect would move all stops far up or down the path, log μ is moved the other way,
so that avalanches still end in the lower part of their path.
"""

from __future__ import annotations

import numpy as np

from avahazard.synth.world import World


def centrifugal(world: World, strength: float) -> dict[str, object]:
    """Curvature loads the bed: the base world has it at 1, strength 0 takes it away."""
    for track in world.tracks:
        track.centrifugal = strength
    return {"loading": strength}


def turbulent_drag(world: World, strength: float) -> dict[str, object]:
    """Deceleration D u², as of Voellmy: D = g / (ξ h), in 1/m."""
    drag = 0.003 * strength
    for track in world.tracks:
        track.quadratic += drag
    world.log_mu -= 0.25 * strength
    return {"drag_per_m": drag, "log_mu": -0.25 * strength}


def speed_weakening(world: World, strength: float) -> dict[str, object]:
    """μ(u) = μ (r + (1 - r) / (1 + u / u0)): friction falls with speed towards r μ."""
    r, u0 = 1.0 - 0.4 * strength, 10.0
    for track in world.tracks:
        track.weakening_r, track.weakening_u0 = r, u0
    world.log_mu += 0.35 * strength
    return {"r": r, "u0_m_s": u0, "log_mu": 0.35 * strength}


def cohesion(world: World, strength: float) -> dict[str, object]:
    """A constant bed resistance c per unit mass, in m/s²."""
    c = 0.8 * strength
    for track in world.tracks:
        track.constant += c
    world.log_mu -= 0.15 * strength
    return {"cohesion_m_s2": c, "log_mu": -0.15 * strength}


def entrainment(world: World, strength: float) -> dict[str, object]:
    """Momentum lost to snow taken up above an elevation: deceleration e u², e in 1/m."""
    e = 0.004 * strength
    z = float(np.round(np.median([s.profile.y_m.max() for s in world.sites]) - 500.0))
    for track in world.tracks:
        track.split(float(track.place(z)))
        track.quadratic += np.where(track.middles() > z, e, 0.0)
    return {"entrainment_per_m": e, "above_m": z}


def forest_drag(world: World, strength: float) -> dict[str, object]:
    """Deceleration D u² in forest cells, D in 1/m."""
    drag = 0.003 * strength
    for track in world.tracks:
        track.quadratic += np.where(track.forest, drag, 0.0)
    return {"drag_per_m": drag}
