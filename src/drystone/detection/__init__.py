"""The contacts of an assembly, with a report of what was found and what was left out."""

from drystone.base.settings import hold
from drystone.detection.contact_report import ContactReport
from drystone.detection.face_overlaps import Overlap
from drystone.detection.find import Detection, GapSweep, find_contacts, find_overlaps, gap_sweep
from drystone.detection.misses import Inexact, Shortfall
from drystone.detection.resample import Resampled
from drystone.detection.tolerances import DetectionOptions, EdgeContacts, Missed, Reason

__all__ = [
    "ContactReport",
    "Detection",
    "DetectionOptions",
    "EdgeContacts",
    "GapSweep",
    "Inexact",
    "Missed",
    "Overlap",
    "Reason",
    "Resampled",
    "Shortfall",
    "find_contacts",
    "find_overlaps",
    "gap_sweep",
]

hold(globals())
