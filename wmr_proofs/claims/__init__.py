"""Claims by theme, in the order of the ledger."""

import tomllib
from dataclasses import replace
from functools import lru_cache
from importlib import import_module
from importlib.resources import files

from wmr_proofs.claim import Claim

THEMES = (
    ("Motion of the robot", "kinematics"),
    ("Regions", "cover"),
    ("The barrier function", "barrier_function"),
    ("Why it works", "structure"),
    ("What the generated C evaluates", "compiled_forms"),
    ("The model-based law", "lyapunov"),
    ("Position errors", "tracking"),
    ("The window argument of Theorem 1", "theorem1 theorem1_turn"),
    ("The adaptive network", "network"),
    ("What does not hold as printed", "errata"),
    ("Which disturbance the barrier withstands", "authority"),
    ("No finite gain from a disturbance", "gain"),
    ("The limits under a held command", "sampled"),
    ("A strict Lyapunov function and an invariant set", "strict"),
    ("The velocity guard", "guard_sample"),
    ("What commands under way count for in the guard", "guard_sent"),
    ("The velocity guard behind a lag that varies", "guard_lag"),
    ("What limits the velocity guard, and its theorems", "guard_limits"),
    ("The guard as it is exported", "guard_exported guard_exported_late guard_flag"),
    ("The guard's parts in controller and simulator", "guard_assembled"),
    ("Wheels behind the guard", "guard_assembled:map_claim"),
    ("The velocity guard in rounded arithmetic", "guard_rounding"),
    ("The velocity guard behind a delay in rounded arithmetic",
     "guard_delay_sums guard_delay_rounding"),
    ("The guard as it is exported", "guard_flag:watched_claim"),
    ("The command filter of bases that take velocities", "command_filter filter_assembled"),
    ("Limits that change, and stops in time", "filter_stops"),
    ("The gate before a base", "gate"),
    ("The command filter of bases that take velocities",
     "filter_loops filter_shapes filter_kick filter_band filter_band_times filter_rounding "
     "filter_command_rounding filter_band_rounding"),
    ("Encoders and wheels", "wheels_and_encoders"),
    ("Motors and late drives", "drive_bounds"),
    ("Commands on their way to a base", "effect_bounds:command_claim"),
    ("Ground, air and sensors", "effect_bounds"),
    ("The barrier's proximal map", "prox:map_claim"),
    ("The level transport", "transport"),
    ("The sampled-data law", "prox"),
    ("The sampled-data law under a push", "prox_push"),
    ("The sampled-data law with a wrong mass", "prox_wrong_mass"),
    ("Prediction over a delay", "composition:prediction_claim"),
    ("The decay of a whole period", "sampled:newton_claim"),
    ("The smooth barrier", "compiled_forms:smooth_claim"),
    ("The certified corridor", "corridor_laws corridor_bases"),
    ("Parts of the arguments by hand", "composition:piece_claim"),
    ("How the parts are put together", "composition"),
)  # fmt: skip
"""Titles, with the files whose claims are below them; of some a list named behind the file."""
BY_HAND = "Arguments by hand, assumptions, open ends"


@lru_cache(maxsize=1)
def all_claims() -> tuple[Claim, ...]:
    """Every claim, with its theme."""
    found, by_hand = list[Claim](), _by_hand()
    for title, places in THEMES:
        for place in places.split():
            file, _, name = place.partition(":")
            claims = vars(import_module(f"wmr_proofs.claims.{file}"))[name or "claim"]
            found += [replace(claim, theme=title) for claim in claims.listed]
        found += [claim for claim in by_hand if claim.theme == title and claim not in found]
    return (*found, *(claim for claim in by_hand if claim.theme == BY_HAND))


def forget() -> None:
    """Drop graphs that were kept, after a change of the product's functions in memory."""
    from .network_axis import network_axis

    network_axis.cache_clear()


def _by_hand() -> list[Claim]:
    """Claims argued by hand, and open ones: words alone."""
    text = files("wmr_proofs.claims").joinpath("by_hand.toml").read_text(encoding="utf-8")
    lists = ("equations", "premises")
    found = tomllib.loads(text)["entry"]
    rows = (row | {key: tuple(row.get(key, ())) for key in lists} for row in found)
    return [Claim(**({"theme": BY_HAND} | row)) for row in rows]
