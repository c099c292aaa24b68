"""Masonry in earthquakes: local collapse mechanisms by the kinematic method."""

from drystone.base.settings import hold
from drystone.seismic.local_mechanism import LocalMechanism, local_mechanism
from drystone.seismic.spectrum import LimitState, SeismicDemand, Spectrum

__all__ = ["LimitState", "LocalMechanism", "SeismicDemand", "Spectrum", "local_mechanism"]

hold(globals())
