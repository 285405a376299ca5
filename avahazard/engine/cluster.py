"""Workers of a dask cluster: an own one on this machine, or that of a scheduler's address."""

from __future__ import annotations

import logging
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import version
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from avahazard.engine import AHEAD, Choice, in_order
from avahazard.engine.processes import call_packed, pack
from avahazard.records.errors import AvahazardError

if TYPE_CHECKING:
    from distributed import Client

TIMEOUT_S = 30
"""How long a scheduler, and its first worker, may take to answer."""

_client: Client | None = None


def require_dask() -> None:
    """Raise `AvahazardError` where dask is not installed."""
    if find_spec("distributed") is None:
        raise AvahazardError(
            "The engine dask needs the package distributed, which is not installed.",
            "Install it: pip install 'avahazard[cluster]'; or take --engine processes.",
        )


def map_dask(
    function: Callable[[Any, Any], Any],
    shared: object,
    items: Iterable[Any],
    choice: Choice,
    n: int,
) -> Iterator[Any]:
    """`spread_map` by the workers of a cluster; an own one has `n`.

    What is shared is a task of its own, so that dask makes it again when the workers that held
    it have died. Raises `AvahazardError` where no scheduler or worker answers, or workers die
    again and again.
    """
    from distributed import KilledWorker  # noqa: PLC0415 (may be missing)
    from distributed.client import FutureCancelledError  # noqa: PLC0415

    client = _connected(choice, n)
    name, data = pack(function, shared)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Sending large graph")  # it is sent once
        held = client.submit(bytes, data, key=f"shared-{name}")
    del data
    ahead = AHEAD * max(sum(client.nthreads().values()), n)

    def first(waiting: deque[Any]) -> Any:
        try:
            return waiting[0].result()
        except KilledWorker as error:
            raise AvahazardError(
                f"Workers of the cluster died again and again on the same work: {error}",
                "Most often memory is short: give a worker more, or fewer threads.",
            ) from error
        except FutureCancelledError as error:
            raise AvahazardError(
                f"The scheduler {client.scheduler.address if client.scheduler else ''} is gone.",
                "Start it again, and the command too: it goes on where it can.",
            ) from error

    def submit(item: object) -> Any:
        return client.submit(call_packed, name, held, item, pure=False)

    yield from in_order(items, ahead, submit, first, lambda waiting: client.cancel(list(waiting)))


def disconnect() -> None:
    """Leave the cluster; an own one ends."""
    global _client
    client, _client = _client, None
    if client is not None:
        cluster = client.cluster
        client.close()
        if cluster is not None:
            cluster.close()


def _connected(choice: Choice, n: int) -> Client:
    global _client  # noqa: PLW0603
    if _client is None:
        _client = _own_cluster(n) if choice.scheduler is None else _of_scheduler(choice.scheduler)
        choice.tell(f"dask: {len(_client.nthreads())} workers, dashboard {_client.dashboard_link}")
    return _client


def _own_cluster(n: int) -> Client:
    import dask  # noqa: PLC0415 (may be missing)
    from distributed import Client, LocalCluster  # noqa: PLC0415

    # Workers complain of lost connections when they are ended.
    dask.config.set({"distributed.logging": {"distributed": "critical"}})
    cluster = LocalCluster(
        n_workers=n,
        threads_per_worker=1,
        # Any free port: the usual one is taken where two run side by side.
        dashboard_address="127.0.0.1:0",
        silence_logs=logging.CRITICAL,
    )
    return Client(cluster)


def _of_scheduler(address: str) -> Client:
    from distributed import Client  # noqa: PLC0415 (may be missing)

    try:
        client = Client(address, timeout=TIMEOUT_S)
    except (OSError, ValueError) as error:
        raise AvahazardError(
            f"No dask scheduler answers at {address}.",
            "Start one with `dask scheduler`, and workers with `dask worker ADDRESS`.",
        ) from error
    try:
        client.wait_for_workers(1, timeout=TIMEOUT_S)
        _require_same_program(client, address)
    except TimeoutError as error:
        client.close()
        raise AvahazardError(
            f"The scheduler {address} has no workers.", f"Start some: dask worker {address}"
        ) from error
    except AvahazardError:
        client.close()
        raise
    return client


def _require_same_program(client: Client, address: str) -> None:
    """Other versions would give other bits, or none."""
    versions = client.run(_version, on_error="return")
    others = sorted({str(v) for v in versions.values() if v != _version()})
    if others:
        raise AvahazardError(
            f"Workers of {address} do not have avahazard {_version()} as here: "
            f"{', '.join(others)}.",
            "Install the same version, with its lock, on all.",
        )


def _version() -> str:
    return version("avahazard")
