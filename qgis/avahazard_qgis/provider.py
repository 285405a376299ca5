"""The provider avahazard of Processing, with the setting of its command."""

from __future__ import annotations

from processing.core.ProcessingConfig import ProcessingConfig, Setting
from qgis.core import QgsProcessingProvider

from .algorithms import ALGORITHMS
from .settings import COMMAND


class AvahazardProvider(QgsProcessingProvider):
    """All algorithms."""

    def id(self):
        """Its name in commands: avahazard:import."""
        return "avahazard"

    def name(self):
        """Its name for people."""
        return "avahazard"

    def load(self):
        """Read the setting, then the algorithms."""
        ProcessingConfig.settingIcons[self.name()] = self.icon()
        words = "The command avahazard, if it is not on the PATH"
        ProcessingConfig.addSetting(
            Setting(self.name(), COMMAND, words, "", valuetype=Setting.FILE)
        )
        ProcessingConfig.readSettings()
        self.refreshAlgorithms()
        return True

    def unload(self):
        """Take the setting away."""
        ProcessingConfig.removeSetting(COMMAND)

    def loadAlgorithms(self):  # noqa: N802
        """Add an instance of each."""
        for algorithm in ALGORITHMS:
            self.addAlgorithm(algorithm())
