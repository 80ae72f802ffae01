"""The paper's claims: how each is put to the test, and the verdict."""

from wmr_ctrl.report.claims.claim import Claim, Judged, Measured, TestSpec, Verdict
from wmr_ctrl.report.claims.judge import judge, judge_all
from wmr_ctrl.report.claims.load import load_claims
from wmr_ctrl.report.claims.sources import PAPER_TIMES, Evidence

__all__ = [
    "PAPER_TIMES",
    "Claim",
    "Evidence",
    "Judged",
    "Measured",
    "TestSpec",
    "Verdict",
    "judge",
    "judge_all",
    "load_claims",
]
