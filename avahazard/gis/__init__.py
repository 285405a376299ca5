"""Maps: lines and terrain models in, map files out. Needs the packages of the extra `gis`."""

from importlib.util import find_spec

from avahazard.records.errors import AvahazardError

NEEDED = ("rasterio", "pyogrio", "shapely", "pyproj")


def require_packages() -> None:
    """Raise `AvahazardError` where a package is missing; to call before `gis` is imported."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise AvahazardError(
            f"Lines, terrain models and map files need {', '.join(missing)}.",
            "Install what they need: pip install 'avahazard[gis]'",
        )
