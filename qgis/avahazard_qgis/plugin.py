"""The plugin: it adds the provider to Processing."""

from __future__ import annotations

from qgis.core import QgsApplication

from .provider import AvahazardProvider


class AvahazardPlugin:
    """Adds the provider while the plugin is on."""

    def __init__(self, _iface):
        """Keep nothing of the interface: qgis_process has none."""
        self.provider = None

    def initProcessing(self):  # noqa: N802
        """Add the provider; all that qgis_process asks for."""
        self.provider = AvahazardProvider()
        QgsApplication.processingRegistry().addProvider(self.provider)

    def initGui(self):  # noqa: N802
        """Add the provider."""
        self.initProcessing()

    def unload(self):
        """Take it away."""
        if self.provider is not None:
            QgsApplication.processingRegistry().removeProvider(self.provider)
