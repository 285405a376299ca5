"""Who does the work: threads of this process, processes of this machine, or a dask cluster."""

from avahazard.engine.choice import ENGINES, close_engine, set_engine
from avahazard.engine.spread import spread_map

__all__ = ["ENGINES", "close_engine", "set_engine", "spread_map"]
