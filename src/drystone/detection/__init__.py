"""The contacts of an assembly, with a report of what was found and what was left out."""

from drystone.base.settings import hold
from drystone.detection.contact_report import ContactReport as ContactReport
from drystone.detection.face_overlaps import Overlap as Overlap
from drystone.detection.find import Detection as Detection
from drystone.detection.find import find_contacts as find_contacts
from drystone.detection.find import find_overlaps as find_overlaps
from drystone.detection.misses import Inexact as Inexact
from drystone.detection.misses import Shortfall as Shortfall
from drystone.detection.resample import Resampled as Resampled
from drystone.detection.tolerances import DetectionOptions as DetectionOptions
from drystone.detection.tolerances import EdgeContacts as EdgeContacts
from drystone.detection.tolerances import Missed as Missed
from drystone.detection.tolerances import Reason as Reason

__all__ = hold(globals())
