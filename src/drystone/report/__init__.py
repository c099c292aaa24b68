"""Calculation reports on paper: what was asked, loads, method, verdict, proof and hand checks."""

from drystone.base.settings import hold
from drystone.report.document import TitleBlock as TitleBlock
from drystone.report.report_pdf import require_pdf as require_pdf
from drystone.report.write_report import assess as assess
from drystone.report.write_report import save_instructions as save_instructions
from drystone.report.write_report import save_joints as save_joints
from drystone.report.write_report import save_study as save_study
from drystone.report.write_report import write_report as write_report

__all__ = hold(globals())
