"""Dynamics of the robot, Eqs. (1), (2), (4), and the friction that the paper leaves open."""

from __future__ import annotations

from wmr_ctrl.model.kinematics import velocity_map
from wmr_ctrl.symbolic import ca


def mass_matrix(m: ca.SX, inertia: ca.SX) -> ca.SX:
    """M = diag(m, m, I), Eq. (2)."""
    return ca.diag(ca.vertcat(m, m, inertia))


def input_matrix(theta: ca.SX, r: ca.SX, half_track: ca.SX) -> ca.SX:
    """B(q), 3x2, Eq. (1): wheel torques (right, left) to forces along x, y and the moment."""
    s, c = ca.sin(theta), ca.cos(theta)
    return ca.vertcat(ca.horzcat(-s, -s), ca.horzcat(c, c), ca.horzcat(half_track, -half_track)) / r


def projected(
    theta: ca.SX, m: ca.SX, inertia: ca.SX, r: ca.SX, half_track: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """(H' M H, H' B), Eq. (4): what `reduced_mass` and `wheel_to_force` are the results of."""
    h = velocity_map(theta)
    return h.T @ mass_matrix(m, inertia) @ h, h.T @ input_matrix(theta, r, half_track)


def reduced_mass(m: ca.SX, inertia: ca.SX) -> ca.SX:
    """Diagonal of M1 = H' M H: (m, I), Eq. (4)."""
    return ca.vertcat(m, inertia)


def wheel_to_force(r: ca.SX, half_track: ca.SX, tau: ca.SX) -> ca.SX:
    """B1 tau with B1 = (1/r) [[1, 1], [l, -l]]: thrust [N] and moment [N m], Eq. (4)."""
    return ca.vertcat(tau[0] + tau[1], half_track * (tau[0] - tau[1])) / r


def force_to_wheel(r: ca.SX, half_track: ca.SX, force: ca.SX) -> ca.SX:
    """B1^-1 F: torques of the right and left wheel [N m]."""
    share = force[1] / half_track
    return 0.5 * r * ca.vertcat(force[0] + share, force[0] - share)


def friction(mu: ca.SX, m: ca.SX, g: ca.SX, v_s: ca.SX, v: ca.SX) -> ca.SX:
    """F1 [N, N m] of Eq. (4), read as Coulomb friction on the linear axis: mu m g tanh(v1/v_s).

    The paper gives only the coefficient mu; none is read into the rotation.
    """
    return ca.vertcat(mu * m * g * ca.tanh(v[0] / v_s), 0)


def acceleration(mass: ca.SX, force: ca.SX, friction_force: ca.SX) -> ca.SX:
    """v' = M1^-1 (B1 tau - F1), Eq. (4) with C1 = 0 (centre of mass on the axle's midpoint)."""
    return (force - friction_force) / mass
