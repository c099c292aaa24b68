"""From an assembly to its contacts, with a report of what was found, left out and why."""

from drystone.detection.find import Detection, find_contacts
from drystone.detection.options import DetectionOptions, EdgeContacts
from drystone.detection.penetration import Penetration
from drystone.detection.report import ContactReport, Missed, Reason

__all__ = [
    "ContactReport",
    "Detection",
    "DetectionOptions",
    "EdgeContacts",
    "Missed",
    "Penetration",
    "Reason",
    "find_contacts",
]
