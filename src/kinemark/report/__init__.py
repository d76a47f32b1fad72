"""How good a trial is: as data, as text for the terminal, and as one HTML page with figures."""

from ..findings.quality import write_quality
from ..findings.trial_records import AboutTrial, TrialRecords
from .page import write_report
from .terminal_summary import summary
from .trial_quality import quality

__all__ = ["AboutTrial", "TrialRecords", "quality", "summary", "write_quality", "write_report"]
