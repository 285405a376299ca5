"""The model and the data it is held against: laws, parameters, observations."""
