"""Masonry in earthquakes: local collapse mechanisms by the kinematic method."""

from drystone.base.settings import hold
from drystone.seismic.local_mechanism import LocalMechanism as LocalMechanism
from drystone.seismic.local_mechanism import local_mechanism as local_mechanism
from drystone.seismic.spectrum import LimitState as LimitState
from drystone.seismic.spectrum import SeismicDemand as SeismicDemand
from drystone.seismic.spectrum import Spectrum as Spectrum

__all__ = hold(globals())
