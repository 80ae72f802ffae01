"""What the project adds to the paper, statement by statement, and the entries that carry each.

Standard library only, as the page that shows it.
"""

from __future__ import annotations

GUARANTEES: tuple[tuple[str, str], ...] = (
    (
        "The guard always has a safe force",
        "guard.feasible guard.axes guard.promise guard.promise-late",
    ),
    (
        "It keeps |v| <= u1 at every instant, for every disturbance, mass, friction and "
        "measurement error within the bounds",
        "guard.upper guard.lower guard.lemma",
    ),
    (
        "From outside it never speeds up, and returns in time, either way",
        "guard.outside guard.return guard.outside-back guard.return-back",
    ),
    ("Braking never overshoots the other limit", "guard.no-overshoot guard.no-overshoot-back"),
    (
        "No guard that intervenes less is safe (nbar = f_min = f_speed = 0, alpha = 1/T)",
        "guard.maximal",
    ),
    ("Beyond its conditions no guard works", "guard.necessary wheels.necessary"),
    ("A bound broken by D costs D T/M_min", "guard.graceful guard.graceful-back"),
    (
        "The monitor accuses no bounds that hold",
        "guard.monitor guard.monitor-quiet guard.monitor-sharp guard.monitor-late",
    ),
    (
        "A torque limit behind the guard keeps what it secured",
        "guard.anchor wheels.reach wheels.linear-first wheels.rotation-first",
    ),
    ("A clip of each wheel by itself does not", "wheels.per-wheel"),
    ("alpha T <= 1 is needed", "guard.too-fast"),
    (
        "In double precision, without delay, the exact robot keeps u1 to the last bit, in the "
        "stated range of its numbers",
        "guard.rounding guard.rounding.force-ahead guard.rounding.force-back guard.rounding.size "
        "guard.rounding.anchor guard.rounding.linear-first guard.rounding.rotation-first "
        "guard.rounding.torques guard.axes guard.lemma",
    ),
    (
        "In single precision likewise, without delay, the limit lowered by 2^-15",
        "guard.rounding.single guard.rounding.single.force-ahead guard.rounding.single.force-back "
        "guard.rounding.single.size guard.rounding.single.anchor "
        "guard.rounding.single.linear-first guard.rounding.single.rotation-first "
        "guard.rounding.single.torques",
    ),
    (
        "Behind a constant delay, in double precision, the exact robot keeps u1 to the last bit, "
        "with any number of commands under way, in the stated range of its numbers",
        "guard.delay.rounding guard.delay.rounding.read guard.delay.rounding.queue-ahead "
        "guard.delay.rounding.queue-ahead-angular guard.delay.rounding.queue-back "
        "guard.delay.rounding.queue-back-angular guard.delay.rounding.both "
        "guard.delay.rounding.both-angular guard.delay.rounding.scaled guard.delay.rounding.brakes "
        "guard.delay.rounding.largest guard.delay.rounding.caps guard.delay.rounding.room "
        "guard.delay.rounding.size guard.delay.rounding.anchor guard.delay.rounding.force-ahead "
        "guard.delay.rounding.force-back guard.delay.rounding.lemma",
    ),
    ("The simulated robot does not outrun what the guard counts with", "guard.simulated"),
    (
        "Behind drives with a delay there is always a safe force, too",
        "guard.delay.caps guard.delay.command guard.delay.command-angular guard.delay.queue "
        "guard.delay.room guard.delay.feasible "
        "guard.delay.largest guard.delay.anchor",
    ),
    (
        "and the limit is kept, or reached again, with T + delay for T in what it costs",
        "guard.delay.upper guard.delay.lower guard.delay.outside guard.delay.return "
        "guard.delay.graceful guard.delay.outside-back guard.delay.return-back "
        "guard.delay.graceful-back guard.delay.necessary guard.delay.lemma",
    ),
    (
        "What sensors, drives and ground add to the guard's assumptions is what their bounds say",
        "world.encoder.v1 world.encoder.omega world.wheels.misread-v1 world.wheels.misread-omega "
        "world.wheels.thrust world.wheels.moment world.motor.step world.motor.dead-zone "
        "world.motor.line world.motor.thrust world.motor.moment world.slope "
        "world.resistance.thrust world.resistance.moment world.gust",
    ),
    (
        "but not with a longer delay than stated, with commands that are not counted, or not "
        "capped",
        "guard.delay.longer guard.delay.ignored guard.delay.uncapped",
    ),
    (
        "With late or averaged velocities, a delay that varies and a lag there is always a safe "
        "force, too",
        "guard.late.caps guard.late.mixed guard.late.piece guard.late.tail guard.late.spare "
        "guard.late.room guard.late.feasible guard.late.largest guard.late.anchor "
        "guard.late.promise guard.late.steady.room guard.late.steady.feasible",
    ),
    (
        "and inside stays inside, a broken bound costs D (T + late)/M_min, and a robot outside is "
        "back near the limit within a known time",
        "guard.late.rest guard.late.mean guard.late.lag guard.late.upper guard.late.lower "
        "guard.late.left guard.late.outside guard.late.graceful guard.late.lemma "
        "guard.late.steady.upper guard.late.steady.lower guard.late.steady.outside "
        "guard.late.steady.left guard.late.steady.graceful "
        "guard.late.steady.return guard.late.outside-back guard.late.graceful-back "
        "guard.late.steady.outside-back guard.late.steady.graceful-back "
        "guard.late.steady.return-back guard.late.return",
    ),
    (
        "The same behind a lag whose time constant varies within known bounds",
        "guard.varying.moved guard.varying.integral guard.varying.piece guard.varying.more "
        "guard.varying.spare guard.varying.left guard.varying.room guard.varying.feasible "
        "guard.varying.counts guard.varying.upper guard.varying.lower guard.varying.outside "
        "guard.varying.graceful guard.varying.steady.graceful "
        "guard.varying.lag guard.varying.lemma world.lag.stepped "
        "guard.varying.steady.spare guard.varying.steady.left guard.varying.steady.room "
        "guard.varying.steady.feasible guard.varying.steady.counts guard.varying.steady.upper "
        "guard.varying.steady.lower guard.varying.steady.outside guard.varying.outside-back "
        "guard.varying.graceful-back guard.varying.steady.outside-back "
        "guard.varying.steady.graceful-back",
    ),
    ("but not where such a lag is taken for constant", "guard.varying.unvaried"),
    (
        "but not with half the window alone, nor where jitter is taken for its largest delay",
        "guard.late.half guard.late.unmixed",
    ),
    (
        "X_k is the barrier's proximal map; it is monotone, not expansive, and ends a known way "
        "below the limit",
        "prox.optimal prox.optimal-smooth prox.monotone prox.monotone-smooth prox.not-expansive "
        "prox.short prox.short-smooth",
    ),
    (
        "Sampled-data law, model exact: V1 falls by exp(-rho T) in a sample with level transport; "
        "with two-part transport S = sqrt(2 V1) by exp(-rho T/2), but for the way of the target "
        "that is not carried; for every T and every motion of the target",
        "prox.rises prox.decay prox.decay-smooth transport.level transport.level-smooth "
        "prox.force prox.force-angular",
    ),
    (
        "Sampled-data law: so does |w|, and |v+| < v_u1, from every velocity",
        "prox.contracts prox.contracts-smooth prox.inside prox.inside-smooth",
    ),
    (
        "Sampled-data law, mass right: a push leaves a bounded distance to the target, from every "
        "velocity",
        "prox.gain",
    ),
    (
        "Sampled-data law, mass right: a push that is small enough never breaks the limit",
        "prox.limit",
    ),
    (
        "Exact decay: one Newton step makes V1 fall and stays on its side of v_c1",
        "convex prox.newton-side prox.newton-side-angular prox.newton prox.newton-angular",
    ),
    (
        "Observer: a push is made up for by exp(-wo T) in a sample",
        "prox.observer prox.observer-angular",
    ),
    (
        "Observer, target held: the loop is stable for M^ <= (4/3) M; a mass that is 3/5 to 8/5 of "
        "the believed one, and changes, does not keep w and f from 0 (stated L and E)",
        "prox.jury prox.light-model prox.any-mass.step prox.any-mass.step-gentle prox.any-mass",
    ),
    (
        "Smooth barrier: where it aims, and 1 <= A/w <= 1 + 1/(u1 - m)^2",
        "smooth.v_c1 smooth.slope smooth.quotient prox.smooth-ratio",
    ),
    (
        "Law (9) has no input-to-state stability at the limit, for either barrier",
        "gain.ceiling gain.ceiling-smooth gain.fades gain.closed gain.closed-smooth gain.cover "
        "gain.none gain.none-smooth gain.levels gain.meaning",
    ),
)
"""(what is guaranteed or denied, ids of its entries)."""
