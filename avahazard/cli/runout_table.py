"""F(μ), its derivative and its jumps as a table for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from avahazard.cli.output import table
from avahazard.results.terrain import Runout, RunoutAt

ROWS = 30
STRIDES = (1, 2, 4, 8, 10, 20, 40)
"""Every how many frictions of the grid a row may stand: steps of μ that are round."""
MOST_JUMPS = 5
COLUMNS = (">μ", ">stop x m", ">elevation m", ">dx/dμ m", ">dy/dμ m", "")
WORDS = {"stopped": "", "left_profile": "leaves the profile", "not_released": "does not move"}


def show_table(console: Console, found: Runout) -> None:
    """Print F(μ) at about `ROWS` frictions, and its largest jumps; nothing without a table."""
    if found.table is None:
        return
    rows = [
        (
            f"{row.mu:.4g}",
            _metres(row.runout_x_m, 1),
            _metres(row.runout_elevation_m, 1),
            _metres(row.dx_dmu_m, 0),
            _metres(row.dy_dmu_m, 0),
            WORDS[row.status],
        )
        for row in thinned(found.table)
    ]
    by = f", with the effects of {found.model}" if found.model else ""
    console.print(table(f"F(μ) on {found.path_id}{by}", COLUMNS, rows))
    console.print("dx/dμ, dy/dμ: by how much stop and elevation move per unit of friction (F′).")
    jumps = sorted(found.jumps or (), key=lambda jump: -abs(jump.from_x_m - jump.to_x_m))
    for jump in jumps[:MOST_JUMPS]:
        console.print(
            f"F jumps between μ = {jump.mu_low:.4f} and {jump.mu_high:.4f}: no friction stops the "
            f"block\nbetween x = {jump.to_x_m:.0f} m and {jump.from_x_m:.0f} m."
        )
    if len(jumps) > MOST_JUMPS:
        console.print(f"{len(jumps) - MOST_JUMPS} smaller jumps: see --json.")


def thinned(rows: Sequence[RunoutAt]) -> list[RunoutAt]:
    """At most about `ROWS` of the rows, evenly, from the last that does not stop to the next."""
    stopped = [j for j, row in enumerate(rows) if row.status == "stopped"]
    if not stopped:
        return [rows[0], rows[-1]]
    first, last = stopped[0], stopped[-1]
    stride = next((s for s in STRIDES if (last - first) // s < ROWS - 1), STRIDES[-1])
    # From a round friction, as the grid begins at one, under which the block does not stop.
    start = max(first - 1 - (first - 1) % stride, 0)
    return list(rows[start : last + stride + 1 : stride])


def _metres(value: float | None, digits: int) -> str | None:
    return None if value is None else f"{value:.{digits}f}"
