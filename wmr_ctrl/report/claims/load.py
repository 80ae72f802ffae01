"""Reading the claims and the committed verdicts from the files beside this one."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any

from wmr_ctrl.report.claims.claim import Claim, Other, TestSpec, Verdict


def load_claims() -> tuple[Claim, ...]:
    """All claims in the report's order, each with its committed verdict.

    Raises KeyError where a claim has no committed verdict, ValueError where a verdict has no claim.
    """
    entries = _data("claims.toml")["claim"]
    verdicts = _data("verdicts.toml")
    orphans = set(verdicts) - {entry["id"] for entry in entries}
    if orphans:
        raise ValueError(f"verdicts.toml names claims that do not exist: {sorted(orphans)}")
    return tuple(_claim(entry, Verdict(verdicts[entry["id"]])) for entry in entries)


def _claim(entry: dict[str, Any], expected: Verdict) -> Claim:
    texts = {name: value for name, value in entry.items() if name != "test"}
    return Claim(**texts, tests=tuple(map(_test, entry["test"])), expected=expected)


def _test(entry: dict[str, Any]) -> TestSpec:
    values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in entry.items()}
    if "over" in values:
        values["over"] = Other(**values["over"])
    return TestSpec(**values)


def _data(name: str) -> dict[str, Any]:
    text = files("wmr_ctrl.report.claims").joinpath(name).read_text(encoding="utf-8")
    return tomllib.loads(text)
