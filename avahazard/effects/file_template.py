"""The template of an effect file."""

from __future__ import annotations

TEMPLATE = '''\
"""An effect of your own. Change this file, then: avahazard add MODEL my-effect --as NEW
--effect-file THIS_FILE. It is plain Python and is run only when you name it.
"""

import numpy as np

from avahazard.effects.effect import Parameter

# One word, by which the effect is called; not one of `avahazard effects`.
KEY = "my-effect"

# What it means, in one or two sentences.
MEANING = "Wet snow rubs more on its bed than dry snow does."

# The columns that it uses; without them it is refused. Besides columns of your files:
# "date", "profile", "land_cover". [] for none.
NEEDS = ["snow_type"]

# Its parameters: at `neutral` the effect is not there; the prior is normal with prior_mean and
# prior_sd, cut to low and high where they are given. Low and high are needed for all functions
# below but friction.
PARAMETERS = [
    Parameter("wet", "log friction", neutral=0.0, prior_mean=0.0, prior_sd=0.2),
]


# Exactly one function, whose name says what the effect acts on. It must not take anything from
# all events together, such as their mean: it is called for other events too.
def friction(columns):
    """A column over the events for each parameter; friction is multiplied by
    exp(parameter x column). Columns of your files are columns.texts["..."] or
    columns.numbers["..."]; there are also year, day_of_winter, log_volume,
    release_elevation, deposit_length and section. A missing number is nan and has no effect.
    """
    return [columns.texts["snow_type"] == "wet"]


# Instead of friction, one of these; each takes the parameters by their names. All give one
# number for all, or one for each cell, speed or event.
#
# def friction_factor(track, name):    what friction is multiplied by, in each cell of the path
# def resistance(track, name):         force per mass against the motion in each cell, m/s2
# def drag(track, name):               d in each cell of a force d u2 per mass, 1/m
#     track.x, track.y (m), track.slope (degrees), track.land_cover, track.path_id, track.section
#
# def speed_factor(speeds, name):      what friction is multiplied by at each speed (m/s)
# def speed_resistance(speeds, name):  force per mass against the motion at each speed, m/s2
#
# def record_shift(columns, name):     metres added to the elevation that is recorded
# def front(columns, name):            metres along the path from the block to the record
#
# Such as:
#
# PARAMETERS = [Parameter("drag", "1/m", neutral=0.0, prior_mean=0.0, prior_sd=0.005,
#                         low=0.0, high=0.03)]
#
# def drag(track, drag):
#     return np.where(track.land_cover == "shrub", drag, 0.0)
'''
