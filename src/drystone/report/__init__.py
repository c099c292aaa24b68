"""Calculation reports on paper: what was asked, loads, method, verdict, proof and hand checks."""

from drystone.base.settings import hold
from drystone.report.document import TitleBlock
from drystone.report.report_pdf import require_pdf
from drystone.report.write_report import (
    assess,
    save_instructions,
    save_joints,
    save_study,
    write_report,
)

__all__ = [
    "TitleBlock",
    "assess",
    "require_pdf",
    "save_instructions",
    "save_joints",
    "save_study",
    "write_report",
]

hold(globals())
