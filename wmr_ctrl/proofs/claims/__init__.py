"""Claims by theme, in the order of the ledger."""

import tomllib
from dataclasses import replace
from functools import lru_cache
from importlib import import_module
from importlib.resources import files

from wmr_ctrl.paper import equations
from wmr_ctrl.proofs.claim import PRINTED, Claim

THEMES = (
    ("kinematics", "Motion of the robot"),
    ("cover", "Regions"),
    ("barrier", "The barrier function"),
    ("structure", "Why it works"),
    ("compiled_forms", "What the generated C evaluates"),
    ("lyapunov", "The model-based law"),
    ("tracking", "Position errors"),
    ("theorem1", "The window argument of Theorem 1"),
    ("theorem1_turn", "The window argument of Theorem 1"),
    ("network", "The adaptive network"),
    ("errata", "What does not hold as printed"),
    ("authority", "Which disturbance the barrier withstands"),
    ("gain", "No finite gain from a disturbance"),
    ("sampled", "The limits under a held command"),
    ("strict", "A strict Lyapunov function and an invariant set"),
    ("guard", "The velocity guard"),
    ("guard_sent", "What commands under way count for in the guard"),
    ("guard_lag", "The velocity guard behind a lag that varies"),
    ("guard_limits", "What limits the velocity guard, and its theorems"),
    ("guard_exported", "The guard as it is exported"),
    ("guard_exported_late", "The guard as it is exported"),
    ("guard_flag", "The guard as it is exported"),
    ("guard_assembled", "The guard's parts in controller and simulator"),
    ("guard_assembled:map_claim", "Wheels behind the guard"),
    ("guard_rounding", "The velocity guard in rounded arithmetic"),
    ("guard_delay_sums", "The velocity guard behind a delay in rounded arithmetic"),
    ("guard_delay_rounding", "The velocity guard behind a delay in rounded arithmetic"),
    ("guard_flag:watched_claim", "The guard as it is exported"),
    ("command_filter", "The command filter of bases that take velocities"),
    ("filter_assembled", "The command filter of bases that take velocities"),
    ("gate", "The gate before a base"),
    ("filter_loops", "The command filter of bases that take velocities"),
    ("filter_kick", "The command filter of bases that take velocities"),
    ("filter_band", "The command filter of bases that take velocities"),
    ("filter_band_times", "The command filter of bases that take velocities"),
    ("filter_force", "The command filter of bases that take velocities"),
    ("filter_rounding", "The command filter of bases that take velocities"),
    ("filter_command_rounding", "The command filter of bases that take velocities"),
    ("filter_band_rounding", "The command filter of bases that take velocities"),
    ("filter_force_rounding", "The command filter of bases that take velocities"),
    ("world", "Encoders and wheels"),
    ("drive_bounds", "Motors and late drives"),
    ("effect_bounds:command_claim", "Commands on their way to a base"),
    ("effect_bounds", "Ground, air and sensors"),
    ("prox:map_claim", "The barrier's proximal map"),
    ("transport", "The level transport"),
    ("prox", "The sampled-data law"),
    ("prox_push", "The sampled-data law under a push"),
    ("prox_wrong_mass", "The sampled-data law with a wrong mass"),
    ("composition:prediction_claim", "Prediction over a delay"),
    ("sampled:newton_claim", "The decay of a whole period"),
    ("compiled_forms:smooth_claim", "The smooth barrier"),
    ("corridor", "The certified corridor"),
    ("corridor_bases", "The certified corridor"),
    ("composition:piece_claim", "Parts of the arguments by hand"),
    ("composition", "How the parts are put together"),
)
"""(file, or file and name of its claims; title)."""
BY_HAND, DEFINITIONS = "Arguments by hand, assumptions, open ends", "Definitions"


@lru_cache(maxsize=1)
def all_claims() -> tuple[Claim, ...]:
    """Every claim, with its theme; definitions come last."""
    found: list[Claim] = []
    for place, title in THEMES:
        file, _, name = place.partition(":")
        claims = vars(import_module(f"wmr_ctrl.proofs.claims.{file}"))[name or "claim"]
        found += [replace(claim, theme=title) for claim in claims.listed]
    return (*found, *_by_hand(), *_definitions())


def forget() -> None:
    """Drop graphs that were kept, after a change of the product's functions in memory."""
    from wmr_ctrl.proofs.claims.network_axis import network_axis

    network_axis.cache_clear()


def _by_hand() -> list[Claim]:
    """Claims argued by hand, and open ones: words alone."""
    text = files("wmr_ctrl.proofs.claims").joinpath("by_hand.toml").read_text(encoding="utf-8")
    lists = ("equations", "premises")
    rows = tomllib.loads(text)["entry"]
    return [
        Claim(**row | {key: tuple(row.get(key, ())) for key in lists}, theme=BY_HAND)
        for row in rows
    ]


def _definitions() -> list[Claim]:
    """One entry for each equation that only gives a name to something."""
    return [
        Claim(
            f"def{row.number:02}",
            (row.number,),
            PRINTED,
            row.title,
            f"{row.note} In the code: {row.home}.".strip(),
            verdict="DEFINITION",
            theme=DEFINITIONS,
        )
        for row in equations()
        if row.role == "definition"
    ]
