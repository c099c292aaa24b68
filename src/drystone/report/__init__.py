"""Calculation reports on paper: what was asked, loads, method, verdict, proof and hand checks."""

from drystone.report.assess import assess
from drystone.report.report_pdf import require_pdf
from drystone.report.title_block import TitleBlock
from drystone.report.write_report import save_study, write_report

__all__ = ["TitleBlock", "assess", "require_pdf", "save_study", "write_report"]
