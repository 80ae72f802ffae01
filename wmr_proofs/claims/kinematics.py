"""Kinematics and dynamics: Eqs. (2)-(8), (33)-(35)."""

from casadi import SX, cos, diag, horzcat, jtimes, reshape, sin, vec, vertcat

from wmr_ctrl.world.model import dynamics, kinematics
from wmr_ctrl.world.model.dynamics import KEYS, plant
from wmr_ctrl.world.model.friction import friction
from wmr_ctrl.world.model.kinematics import error_rate, pose_rate
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs import paper_functions
from wmr_proofs.claim import CORRECTED, OURS, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Ring
from wmr_proofs.paper_functions import constraint, velocity_map
from wmr_proofs.regions import POSITIVE, Case
from wmr_proofs.statement import Statement, column, every, stacked, symbols

from .common import PRESET, ports_of, scalars

MASSES = (Case("all", {"m": POSITIVE, "I": POSITIVE, "r": POSITIVE, "l": POSITIVE}, dict),)
DECLARED = (Case("all", declared=dict.fromkeys(("m", "I", "r", "l"), POSITIVE)),)
ROBOT = (Case("all", declared={f"robot.{n}": POSITIVE for n in ("m", "I", "r", "l", "v_s")}),)
claim = Claims(by=Ring(), form=PRINTED)


@claim("eq03", (3, 5), form=CORRECTED)
def no_sideways(mutation: Mutation) -> Statement:
    """A(q)' q' = 0 for q' = H(q) v (the text after (3) prints A(q) q' = 0, whose sizes do not fit).

    The simulated robot never slides sideways.

    Given: {ANY_POSE}.
    """
    t = symbols("theta v1 v2")
    rate = pose_rate(t.theta, vertcat(t.v1, t.v2))
    return Statement(t, constraint(t.theta).T @ (rate * vertcat(mutation, 1, 1)) == 0)


@claim("eq04.null-space", (4, 5))
def null_space(mutation: Mutation) -> Statement:
    """H(q)' A(q) = 0.

    The forces that keep the wheels from sliding drop out of the equations of motion.

    Given: any theta.
    """
    t = symbols("theta")
    h = velocity_map(t.theta) * vertcat(horzcat(mutation, 1), SX.ones(2, 2))
    return Statement(t, every(h.T @ constraint(t.theta), SX(2, 1)))


@claim("eq05", (5,))
def rate_is_map(mutation: Mutation) -> Statement:
    """the pose rate of the plant is H(q) v (H as printed, transposed).

    Forward is (-sin theta, cos theta): theta is measured from the Y axis.

    Given: {ANY_POSE}.
    """
    t = symbols("theta v1 v2")
    v = vertcat(t.v1, t.v2)
    mapped = velocity_map(t.theta) @ (v * vertcat(mutation, 1))
    return Statement(t, every(pose_rate(t.theta, v), mapped))


@claim("eq06", (6,))
def velocity_back(mutation: Mutation) -> Statement:
    """H(q)' q' = v: v1 is the speed ahead and v2 the turning rate.

    The two velocities are the ones that a sensor would measure.

    Given: {ANY_POSE}.
    """
    t = symbols("theta v1 v2")
    v = vertcat(t.v1, t.v2)
    back = velocity_map(t.theta).T @ (pose_rate(t.theta, v) * vertcat(1, mutation, 1))
    return Statement(t, every(back, v))


@claim("eq04", (1, 4), by=Ring(DECLARED))
def projection(mutation: Mutation) -> Statement:
    """H' times (1), with q' = H v and no Coriolis matrix, is M1 v' + F1 = B1 tau; the constraint
    force is gone.

    Two equations of motion are enough; the wheels' side forces are not needed.

    Given: any pose and velocity; m, I, r, l > 0; C(q, q') = 0: centre of mass on the axle's
    midpoint.
    """
    t = symbols("theta m I r l lam v1 v2 vdot1 vdot2 tau1 tau2 F1 F2 F3", "m I r l")
    theta, v, tau = t.theta, stacked(t, "v", 2), stacked(t, "tau", 2)
    h, mass = velocity_map(theta), paper_functions.mass_matrix(t.m, t.I)
    h_dot = reshape(jtimes(vec(h), theta, v[1]), 3, 2)
    inner = mass @ (h @ stacked(t, "vdot", 2) + h_dot @ v) + stacked(t, "F", 3)
    push = paper_functions.input_matrix(theta, t.r, t.l) @ tau + constraint(theta) * t.lam
    reduced = dynamics.reduced_mass(t.m, t.I) * stacked(t, "vdot", 2)
    right = reduced + h.T @ stacked(t, "F", 3) - mutation * dynamics.wheel_to_force(t.r, t.l, tau)
    return Statement(t, every(h.T @ (inner - push), right))


@claim("eq04.reduced", (2, 4), by=Ring(MASSES))
def eq04_reduced(mutation: Mutation) -> Statement:
    """M1 = H' M H = diag(m, I), H' B = B1, H' M H' = 0 (so C1 = 0).

    Thrust and turning are decoupled.

    Given: any pose and velocity, m, I, r, l > 0.
    """
    t = symbols("theta m I r l omega", "m I r l") | column("tau", 2)
    theta, tau = t.theta, stacked(t, "tau", 2)
    mass, push = paper_functions.projected(theta, t.m, t.I, t.r, t.l)
    h = velocity_map(theta)
    h_dot = reshape(jtimes(vec(h), theta, t.omega), 3, 2)
    coriolis = h.T @ paper_functions.mass_matrix(t.m, t.I) @ h_dot
    masses = every(mass, diag(dynamics.reduced_mass(mutation * t.m, t.I)))
    forces = every(push @ tau, dynamics.wheel_to_force(t.r, t.l, tau))
    return Statement(t, (masses, forces, every(coriolis, SX(2, 2))))


@claim("eq04.plant", (1, 4, 5), form=OURS, by=Ring(ROBOT))
def eq04_plant(mutation: Mutation) -> Statement:
    """the simulated plant's rates satisfy M1 v' + F1 = B1 (tau + noise) and q' = H v.

    The simulated robot is the one that the theorems are about.

    Given: any pose and velocity; m, I, r, l, v_s > 0.
    """
    system = plant(load_scenario(PRESET))
    t = scalars(ports_of(system))
    m, inertia, mu, r, l, g, v_s = (t[key] for key in KEYS)
    v = vertcat(t.v1, t.omega)
    tau = vertcat(t.tau_right + t.noise_right, t.tau_left + mutation * t.noise_left)
    inertial = dynamics.reduced_mass(m, inertia) * system.update[3:5]
    force = dynamics.wheel_to_force(r, l, tau) + vertcat(t.thrust, t.moment)
    moves = every(system.update[0:3], velocity_map(t.theta) @ v)
    return Statement(t, (every(inertial + friction(mu, m, g, v_s, v), force), moves))


@claim("eq04.wheels", (4,), form=OURS, by=Ring(DECLARED))
def eq04_wheels(mutation: Mutation) -> Statement:
    """B1 (B1^-1 F) = F for the torques that the laws send.

    The wheels produce exactly the thrust and moment that a law asks for.

    Given: r, l > 0.
    """
    t = symbols("r l F N", "r l")
    force = vertcat(t.F, t.N)
    wheels = dynamics.force_to_wheel(t.r, t.l, force) * vertcat(mutation, 1)
    return Statement(t, every(dynamics.wheel_to_force(t.r, t.l, wheels), force))


@claim("eq33-35", (8, 33, 34, 35), by=Ring(spare=12))
def eq33_35(mutation: Mutation) -> Statement:
    """differentiating (8) along both robots' motions gives (33)-(35).

    The tracking error that the laws use evolves as the proof says.

    Given: {ANY_POSE}; the desired motion obeys (3), too.
    """
    t = column("q", 3) | column("d", 3) | column("v", 2) | column("vd", 2)
    pose, pose_d = stacked(t, "q", 3), stacked(t, "d", 3)
    v, v_d = stacked(t, "v", 2), stacked(t, "vd", 2)
    motion = vertcat(pose_rate(pose[2], v), pose_rate(pose_d[2], v_d))
    e = kinematics.tracking_error(pose_d, pose)
    rate = jtimes(e, vertcat(pose, pose_d), motion)
    return Statement(t, every(rate, error_rate(e, v * vertcat(1, mutation), v_d)))


@claim("eq07.rate", (7,), form=OURS)
def target_rate(mutation: Mutation) -> Statement:
    """the rate of v_c0 that the laws feed forward is the derivative of (7).

    The feed-forward is exact, not a difference quotient.

    Given: {ANY_POSE}.
    """
    t = column("e", 3) | column("v", 2) | column("vd", 2) | column("a", 2) | column("k", 3)
    e, v, v_d = stacked(t, "e", 3), stacked(t, "v", 2), stacked(t, "vd", 2)
    rate = error_rate(e, v, v_d)
    c = cos(e[2])
    first = t.a1 * c - mutation * v_d[0] * sin(e[2]) * rate[2] + t.k1 * rate[0]
    second = t.a2 + t.k2 * (t.a1 * e[1] + v_d[0] * rate[1]) + t.k3 * c * rate[2]
    used = kinematics.auxiliary_rate(e, v, v_d, stacked(t, "a", 2), stacked(t, "k", 3))
    return Statement(t, every(used, vertcat(first, second)))
