"""Processing algorithms of avahazard in QGIS."""


def classFactory(iface):  # noqa: N802 (the name that QGIS asks for)
    """Return the plugin."""
    from .plugin import AvahazardPlugin  # noqa: PLC0415 (QGIS has to be there)

    return AvahazardPlugin(iface)
