"""What the project adds to the paper, statement by statement, and the entries that carry each.

Standard library only, as the page that shows it.
"""

from __future__ import annotations

GUARANTEES: tuple[tuple[str, str], ...] = (
    ("The guard always has a safe force", "guard.feasible"),
    (
        "It keeps |v| <= u1 at every instant, for every disturbance, mass, friction and "
        "measurement error within the bounds",
        "guard.upper guard.lower guard.lemma",
    ),
    ("From outside it never speeds up, and returns in time", "guard.outside guard.return"),
    ("Braking never overshoots the other limit", "guard.no-overshoot"),
    (
        "No guard that intervenes less is safe (nbar = f_min = f_speed = 0, alpha = 1/T)",
        "guard.maximal",
    ),
    ("Beyond its conditions no guard works", "guard.necessary wheels.necessary"),
    ("A bound broken by D costs D T/M_min", "guard.graceful guard.monitor"),
    (
        "A torque limit behind the guard keeps what it secured",
        "guard.anchor wheels.reach wheels.linear-first wheels.rotation-first",
    ),
    ("A clip of each wheel by itself does not", "wheels.per-wheel"),
    ("alpha T <= 1 is needed", "guard.too-fast"),
    (
        "What the guard keeps back is more than the rounding of its bound near the limit (not "
        "closed: the text of the entries says what is left out)",
        "guard.rounding guard.delay.rounding",
    ),
    (
        "Behind drives with a delay there is always a safe force, too",
        "guard.delay.caps guard.delay.command guard.delay.command-angular guard.delay.queue "
        "guard.delay.room guard.delay.feasible "
        "guard.delay.largest guard.delay.anchor",
    ),
    (
        "and the limit is kept, or reached again, with T + delay for T in what it costs",
        "guard.delay.upper guard.delay.lower guard.delay.outside guard.delay.return "
        "guard.delay.graceful guard.delay.necessary guard.delay.lemma",
    ),
    (
        "but not with a longer delay than stated, with commands that are not counted, or not "
        "capped",
        "guard.delay.longer guard.delay.ignored guard.delay.uncapped",
    ),
    (
        "X_k is the barrier's proximal map; it is monotone, not expansive, and keeps its target",
        "prox.optimal prox.optimal-smooth prox.monotone prox.monotone-smooth prox.not-expansive "
        "prox.fixed-point",
    ),
    (
        "Sampled-data law: V1 falls by exp(-rho T) from v* to v+, for every T; v* = v where the "
        "target is held",
        "prox.implicit prox.decay convex",
    ),
    (
        "Sampled-data law: |w| falls by exp(-rho T/2); the paper's barrier keeps |v+| < v_u1",
        "prox.contracts prox.inside",
    ),
    (
        "Exact decay: one Newton step makes V1 fall and stays on its side of v_c1",
        "convex prox.newton-side prox.newton-side-angular prox.newton prox.newton-angular",
    ),
    ("Observer: stable for M^ <= (4/3) M", "prox.jury prox.light-model"),
    (
        "Smooth barrier: where it aims, and 1 <= A/w <= 1 + 1/(u1 - m)^2",
        "smooth.v_c1 smooth.slope smooth.quotient prox.smooth-ratio",
    ),
    (
        "Law (9) has no input-to-state stability at the limit, for either barrier",
        "gain.ceiling gain.ceiling-smooth gain.fades gain.closed gain.closed-smooth gain.cover "
        "gain.none gain.none-smooth gain.levels gain.meaning",
    ),
    ("The gradient law has it while its target is held", "prox.bounded-push convex"),
)
"""(what is guaranteed or denied, ids of its entries)."""
