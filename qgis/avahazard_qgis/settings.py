"""The setting of the provider."""

COMMAND = "AVAHAZARD_COMMAND"
