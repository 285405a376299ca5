"""The posterior mode, sought and made sure of."""
