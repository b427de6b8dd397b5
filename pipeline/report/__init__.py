"""The report of a run: one page that people open, with the machine in motion and every figure that counts."""

from pipeline.report.build import RunResults, build_report
from pipeline.report.data import Report
from pipeline.report.page import render_page
from pipeline.report.verdicts import StageFacts

__all__ = ["Report", "RunResults", "StageFacts", "build_report", "render_page"]
