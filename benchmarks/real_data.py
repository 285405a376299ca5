"""The loop on real records beside a plain regression; writes the tables of docs/real-data.md.

make real-data, or … -m benchmarks.real_data NAME… for some of the sets. The records are not part
of the project; the results are kept in real_data.jsonl.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.compare import compare, predict
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from benchmarks.study import DOCS, HERE, SHARED, Line, keep, lines, table, write_parts

FOUND = HERE / "real_data.jsonl"
SPLIT_SEED = 13
"""Of the held-out third; no other was tried."""
MOST_ROUNDS, N_DRAWS = 2, 2000


@dataclass(frozen=True, slots=True)
class DataSet:
    """A folder of records, the law it is read by, and what was expected before looking.

    The regressions are on log V and on these columns: levels as dummies, numbers as cubics.
    """

    folder: str
    law: str
    expect: tuple[str, ...] = ()
    keeps_third: bool = True
    regressions: tuple[tuple[str, ...], ...] = ()


DATA_SETS = (
    DataSet(
        "rock-avalanches-canada",
        "power",
        ("covariate:confinement",),
        regressions=((), ("confinement",)),
    ),
    DataSet("submarine-slides", "power", regressions=((), ("mean_slope_deg",))),
    DataSet("avanodes", "constant", keeps_third=False),
)


def run(data: DataSet) -> Line:
    """Calibrate, ask what is missing, add it; score every model on the held-out records."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        database = str(folder / "real.db")
        source, kept = SHARED / data.folder, None
        found: Line = {"name": data.folder, "law": data.law, "expect": list(data.expect)}
        if data.keeps_third:
            source, kept = split(source / "events.csv", folder)
            found["regressions"] = [regression(source, kept, r) for r in data.regressions]
        init_database(database)
        import_files(database, [source])
        calibrate(database, "model-0", CalibrateRequest(law=data.law))
        found["rounds"] = []
        for k in range(MOST_ROUNDS + 1):
            expect = data.expect if k == 0 else ()
            verdict = diagnose_model(
                database, f"model-{k}", DiagnoseRequest(expect=expect)
            ).to_dict()
            columns = ("effect", "gain", "p_value", "p_value_alone", "force_witness")
            told = {key: verdict[key] for key in ("verdict", "missing", "impossible_stops")}
            told["candidates"] = [{c: one[c] for c in columns} for one in verdict["candidates"][:4]]
            found["rounds"].append(scored(database, f"model-{k}", kept) | told)
            if not addable(verdict) or k == MOST_ROUNDS:
                break
            add(database, f"model-{k}", verdict["missing"], f"model-{k + 1}")
        if data.expect:
            # What was declared is scored too, whether it was named or not.
            add(database, "model-0", list(data.expect), "declared")
            found["declared"] = scored(database, "declared", kept)
        return found


def addable(verdict: Line) -> bool:
    """Whether one effect is named, or one column that no physics explains, as a user may add it."""
    missing = verdict["missing"]
    if len(missing) != 1:
        return False
    return verdict["verdict"] == "missing-effect" or missing[0].startswith("covariate:")


def scored(database: str, model: str, kept: Path | None) -> Line:
    """Scores held-out by fold or path, and on the held-out third."""
    compared = compare(database, model).to_dict()
    slim = {"n": compared["scores"]["runout"]["n"], "held_out": compared["held_out"]}
    third = None if kept is None else predict(database, model, kept).scores
    return slim | {"kept": None if third is None else third.to_dict()}


def split(events: Path, folder: Path) -> tuple[Path, Path]:
    """Two thirds of the rows to learn from, and a third drawn at random to judge by."""
    rows = pd.read_csv(events, dtype=str, keep_default_na=False)
    order = np.random.default_rng(SPLIT_SEED).permutation(len(rows))
    third = np.isin(np.arange(len(rows)), order[: len(rows) // 3])
    files = folder / "events.csv", folder / "kept.csv"
    for file, part in zip(files, (~third, third), strict=True):
        rows[part].to_csv(file, index=False)
    return files


def regression(learnt: Path, kept: Path, columns: tuple[str, ...]) -> Line:
    """Least squares of log(H/L), judged as the models are: CRPS (m of L), share in 90 %, density.

    Predictions are Student's t; `p_extra` is the F test of all columns beside the volume.
    """
    train, test = (pd.read_csv(file).dropna(subset="volume_m3") for file in (learnt, kept))
    y, truth = (
        np.log(rows.fall_height_m / rows.runout_length_m).to_numpy() for rows in (train, test)
    )
    x, names = _design(train, train, columns)
    new, _ = _design(test, train, columns)
    beta, squares, freedom = _least_squares(x, y)
    variance, inverse = squares / freedom, np.linalg.inv(x.T @ x)
    middle = new @ beta
    scale = np.sqrt(variance * (1.0 + np.einsum("ij,jk,ik->i", new, inverse, new)))
    z = np.random.default_rng(0).standard_t(freedom, (len(test), N_DRAWS))
    height, length = (test[c].to_numpy(float) for c in ("fall_height_m", "runout_length_m"))
    draws = height[:, None] / np.exp(middle[:, None] + scale[:, None] * z)
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    # The density of L, as the product gives it.
    density = stats.t.logpdf((truth - middle) / scale, freedom) - np.log(scale * length)
    weight = (2 * np.arange(1, N_DRAWS + 1) - N_DRAWS - 1) / N_DRAWS**2
    crps = np.abs(draws - length[:, None]).mean(axis=1) - np.sort(draws, axis=1) @ weight
    _, fewer, more = _least_squares(_design(train, train, ())[0], y)
    ratio = (fewer - squares) / max(more - freedom, 1) / variance
    return {
        "columns": ["log V", *columns],
        "crps_m": float(np.mean(crps)),
        "coverage_90": float(np.mean((low <= length) & (length <= high))),
        "elpd": float(np.sum(density)),
        "coefficients": {
            name: {"value": float(b), "se": float(np.sqrt(variance * inverse[k, k]))}
            for k, (name, b) in enumerate(zip(names, beta, strict=True))
        },
        "p_extra": float(stats.f.sf(ratio, more - freedom, freedom)) if columns else None,
    }


def _least_squares(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, float, int]:
    """Coefficients, sum of squares that is left, and degrees of freedom."""
    beta, *_ = np.linalg.lstsq(x, y, rcond=None)
    return beta, float(np.sum((y - x @ beta) ** 2)), len(y) - x.shape[1]


def _design(
    rows: pd.DataFrame, train: pd.DataFrame, columns: tuple[str, ...]
) -> tuple[np.ndarray, list[str]]:
    """Columns `[n, n_columns]` and their names."""
    made = {"1": np.ones(len(rows))}
    made["log V"] = (np.log(rows.volume_m3) - np.log(train.volume_m3).mean()).to_numpy()
    for column in columns:
        known, value = train[column], rows[column].to_numpy()
        if pd.api.types.is_numeric_dtype(known):
            z = (value - known.mean()) / known.std(ddof=0)
            made |= {f"{column}^{power}": z**power for power in (1, 2, 3)}
        else:
            made |= {f"{column} {v}": value == v for v in sorted(known.unique())[1:]}
    return np.column_stack(list(made.values())).astype(float), list(made)


def tables(found: list[Line]) -> dict[str, str]:
    """The tables of each set."""
    return {one["name"]: "\n\n".join(_tables(one)) for one in found}


def _tables(found: Line) -> list[str]:
    rounds = found["rounds"]
    names = []
    for k in range(len(rounds)):
        added = [key for one in rounds[:k] for key in one["missing"]]
        names.append(f"{found['law']} law" + (f" with {', '.join(added)}" if added else ""))
    rows = []
    for name, one in zip(names, rounds, strict=True):
        best = "; ".join(
            f"{c['effect']} {c['gain']:.1f}, {_p(c['p_value'])}, {_p(c['p_value_alone'])}"
            for c in one["candidates"][:3]
        )
        rows.append((name, f"`{one['verdict']}`", ", ".join(one["missing"]) or "–", best))
    head = ("model", "verdict", "named", "leading candidates: gain (nats), family-wise p, p alone")
    texts = [table(head, rows)]
    if stops := rounds[0]["impossible_stops"]:
        texts.append(f"Stops recorded on ground too steep for any block: {', '.join(stops)}.")
    if rounds[0]["kept"] is None:
        return [*texts, *_speeds(names, rounds)]
    scores = list(zip(names, rounds, strict=True))
    if "declared" in found:
        scores.append((f"with {', '.join(found['expect'])}, as declared", found["declared"]))
    rows = [
        (name, *_cells(one["kept"]["runout"], one["kept"]["elpd_loo"]),
         f"{one['held_out']['runout']['crps_m']:,.0f}")
        for name, one in scores
    ]  # fmt: skip
    terms = []
    for one in found["regressions"]:
        name = ", ".join(one["columns"])
        rows.append((f"regression on {name}", *_cells(one, one["elpd"]), "–"))
        each = [f"{k} {c['value']:.3f} ± {c['se']:.3f}" for k, c in one["coefficients"].items()]
        p = "–" if one["p_extra"] is None else _p(one["p_extra"])
        terms.append((name, ", ".join(each[1:]), p))
    return [
        f"Fitted to {rounds[0]['n']} events, scored on {rounds[0]['kept']['runout']['n']} "
        "held-out ones.",
        *texts,
        table(("", "CRPS of the held-out third (m)", "90 % coverage", "log density",
               "CRPS by folds (m)"), rows),
        table(("regression on", "coefficients on log(H/L)", "F test of all but log V: p"), terms),
    ]  # fmt: skip


def _cells(score: Line, density: float) -> tuple[str, str, str]:
    return f"{score['crps_m']:,.0f}", f"{score['coverage_90']:.0%}", f"{density:.1f}"


def _speeds(names: list[str], rounds: list[Line]) -> list[str]:
    rows = []
    for name, one in zip(names, rounds, strict=True):
        speed, runout = one["held_out"]["speed"], one["held_out"]["runout"]
        rows.append((name, f"{speed['crps_m_s']:.1f}", f"{speed['coverage_90']:.0%}",
                     f"{runout['crps_m']:.0f}", f"{runout['coverage_90']:.0%}"))  # fmt: skip
    head = (
        "held-out by path",
        "CRPS of speed (m/s)",
        "90 % coverage",
        "CRPS of runout (m)",
        "90 % coverage",
    )
    force = [
        f"{c['effect']} {c['force_witness']['value']:.2g} ± {c['force_witness']['se']:.2g}"
        for c in rounds[0]["candidates"]
        if c["force_witness"] is not None
    ]
    return [table(head, rows), *([f"The measured force: {'; '.join(force)}."] if force else [])]


def _p(value: float) -> str:
    return "< 0.001" if value < 0.001 else f"{value:.3f}"


def main(names: list[str]) -> None:
    """Run what is named, keep it, and write the page of all that was kept."""
    for data in DATA_SETS:
        if not names or data.folder in names:
            keep(FOUND, run(data))
    write_parts(DOCS / "real-data.md", tables(lines(FOUND)))


if __name__ == "__main__":
    main(sys.argv[1:])
