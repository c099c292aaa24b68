"""From an assembly to its contacts, with a report of what was found, left out and why."""

from drystone.detection.find import Detection, find_contacts
from drystone.detection.freeform import regroup
from drystone.detection.given import contacts_from_mesh
from drystone.detection.options import DetectionOptions, EdgeContacts
from drystone.detection.penetration import Penetration
from drystone.detection.reasons import Missed, Reason
from drystone.detection.report import ContactReport
from drystone.detection.shortfall import Shortfall
from drystone.detection.sweep import GapSweep, gap_sweep

__all__ = [
    "ContactReport",
    "Detection",
    "DetectionOptions",
    "EdgeContacts",
    "GapSweep",
    "Missed",
    "Penetration",
    "Reason",
    "Shortfall",
    "contacts_from_mesh",
    "find_contacts",
    "gap_sweep",
    "regroup",
]
