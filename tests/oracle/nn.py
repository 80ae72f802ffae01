"""Adaptive radial-basis-function law, Eqs. (57) and (58)."""

import itertools

import numpy as np


class NeuralNetwork:
    """F = -rho1 V1/A + q W^T S(Z), S Gaussian at the 64 corners of a cube of six dimensions."""

    def __init__(self, gains, scenario):
        self.gains = gains
        self.T = scenario.clock.control
        self.nodes = gains["node"] * np.array(list(itertools.product((-1.0, 1.0), repeat=6)))
        self.W = np.zeros((2, len(self.nodes)))

    def act(self, sight):
        """Generalised force (thrust [N], moment [N m]); the weights follow Eq. (58)."""
        S = self._basis(sight)
        force = [
            -self.gains["rho1"][i] * b.V1_by_A + b.q * float(self.W[i] @ S)
            for i, b in enumerate(sight.barrier)
        ]
        for i, b in enumerate(sight.barrier):
            self.W[i] = self._learned(i, S * b.gap)
        return force[0], force[1]

    def _basis(self, sight):
        """S(Z) (64,) at Z = (v_c0', 1/q, v)."""
        Z = np.array((*sight.v_c0_dot, *map(self._regressor, sight.barrier), *sight.v))
        squares = ((Z - self.nodes) ** 2).sum(axis=1)
        S = np.exp(-squares / self.gains["eta"] ** 2)
        return S

    def _regressor(self, b):
        """q, or A/(v - v_c1) = 1/q, capped."""
        if self.gains.get("regressor") == "q":
            return b.q
        cap = float(self.gains["ratio_cap"])
        return cap if b.q <= 1.0 / cap else 1.0 / b.q

    def _learned(self, i, drive):
        """Weights of axis ``i`` one control step later; ``drive`` = S (v - v_c1)."""
        Gamma, sigma, W, T = self.gains["Gamma"][i], self.gains["sigma"][i], self.W[i], self.T
        if self.gains["integrator"] == "semi-implicit":
            return np.asarray((W - T * Gamma * drive) / (1.0 + T * Gamma * sigma))
        return np.asarray(W - T * Gamma * (drive + sigma * W))

    def memory(self):
        """Euclidean norms of both axes' weights, after the update."""
        return {"W_norm": (float(np.linalg.norm(self.W[0])), float(np.linalg.norm(self.W[1])))}
