"""The contacts of an assembly, with a report of what was found and what was left out."""

from drystone.detection.block_overlaps import Overlap
from drystone.detection.contact_report import ContactReport
from drystone.detection.detection_options import DetectionOptions, EdgeContacts
from drystone.detection.find import Detection, find_contacts, find_overlaps
from drystone.detection.gap_sweep import GapSweep, gap_sweep
from drystone.detection.inexact import Inexact
from drystone.detection.reasons import Missed, Reason
from drystone.detection.resample import Resampled
from drystone.detection.shortfall import Shortfall

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
