"""How likely the records are: nodes over friction, terms of events, the posterior."""
