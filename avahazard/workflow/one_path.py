"""One path of the records, found by its name, and made ready to run."""

from __future__ import annotations

from avahazard.effects.site import Site, build_site, release_place
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.path import Path, Profile


def find_path(records: Records, path_id: str) -> Path:
    """Return the path of this name.

    Raises:
        AvahazardError: there is none; the hint lists those that there are.
    """
    for path in records.paths:
        if path.path_id == path_id:
            return path
    names = [path.path_id for path in records.paths]
    if not names:
        hint = "There are no paths yet: import some with `avahazard import`."
    else:
        more = f" and {len(names) - 12} more" if len(names) > 12 else ""
        hint = f"The paths are: {', '.join(names[:12])}{more}."
    raise AvahazardError(f"There is no path '{path_id}'.", hint)


def find_profile(records: Records, path: Path) -> Profile:
    """Return the profile of a path.

    Raises:
        AvahazardError: none is stored.
    """
    for profile in records.profiles:
        if profile.path_id == path.path_id:
            return profile
    raise AvahazardError(
        f"No profile is stored for path {path.path_id}.",
        "Import a profiles.csv with the points of this path.",
    )


def path_site(path: Path, profile: Profile) -> Site:
    """Return the regularised path with one release: the path's own, else its top."""
    smooth = smooth_profile(profile.x_m, profile.y_m)
    return build_site(path, profile, smooth, [release_place(smooth, path.release_elevation_m)])
