"""The report of a study: one page to open in a browser, offline, with pictures of all runs and links to each."""

from pipeline.study.report.page import REPORT, render_study

__all__ = ["REPORT", "render_study"]
