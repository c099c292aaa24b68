"""The contacts of an assembly, with a report of what was found and what was left out."""

from drystone.detection.detection_options import DetectionOptions, EdgeContacts
from drystone.detection.find import Detection, find_contacts, find_overlaps
from drystone.detection.freeform.given import contacts_from_mesh
from drystone.detection.freeform.regroup import regroup
from drystone.detection.freeform.shortfall import Shortfall
from drystone.detection.report.block_overlaps import Overlap
from drystone.detection.report.contact_report import ContactReport
from drystone.detection.report.gap_sweep import GapSweep, gap_sweep
from drystone.detection.report.inexact import Inexact
from drystone.detection.report.reasons import Missed, Reason

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
    "Shortfall",
    "contacts_from_mesh",
    "find_contacts",
    "find_overlaps",
    "gap_sweep",
    "regroup",
]
