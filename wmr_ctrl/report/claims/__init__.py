"""The paper's claims: how each is put to the test, and the verdict."""

from wmr_ctrl.report.claims.claim import (
    STAND_IN_LAW,
    Divisor,
    Judged,
    Measured,
    PaperClaim,
    Quoted,
    TestSpec,
    Verdict,
    load_claims,
)
from wmr_ctrl.report.claims.judge import PAPER_TIMES, RULE, Evidence, judge, judge_all, verdict_of

__all__ = [
    "PAPER_TIMES",
    "RULE",
    "STAND_IN_LAW",
    "Divisor",
    "Evidence",
    "Judged",
    "Measured",
    "PaperClaim",
    "Quoted",
    "TestSpec",
    "Verdict",
    "judge",
    "judge_all",
    "load_claims",
    "verdict_of",
]
