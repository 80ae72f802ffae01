"""Somebody else's FMUs, as sources for PythonFMU: other names, units and sampling than ours."""

_ROBOT = '''
import math
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class {name}(Fmi2Slave):
    """A differential drive: torques in mN m with the disturbance in them, angles in deg."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.motorR = self.motorL = 0.0
        self.px, self.py, self.heading = -0.5, -0.5, math.degrees(-0.7 + math.pi / 2)
        self.wheelR = self.wheelL = 0.0
        for name in ("motorR", "motorL"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("px", "py", "heading", "wheelR", "wheelL"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def rate(self, state):
        m, inertia, mu, r, half = 50.0, 5.4, 0.08, 0.1, 0.25
        x, y, psi, v, w = state
        right, left = self.motorR / 1000, self.motorL / 1000
        friction = mu * m * 9.81 * math.tanh(v / 0.01)
        v_dot = ((right + left) / r - friction) / m
        w_dot = half * (right - left) / r / inertia
        return (v * math.cos(psi), v * math.sin(psi), w, v_dot, w_dot)

    def do_step(self, t, h):
        {failure}
        r, half = 0.1, 0.25
        right, left = self.wheelR * 2 * math.pi / 60, self.wheelL * 2 * math.pi / 60
        v, w = r * (right + left) / 2, r * (right - left) / (2 * half)
        s = (self.px, self.py, math.radians(self.heading), v, w)
        n = max(1, round(h / 2.5e-4))
        for _ in range(n):
            k1 = self.rate(s)
            k2 = self.rate([a + h / n / 2 * b for a, b in zip(s, k1)])
            s = [a + h / n * b for a, b in zip(s, k2)]
        self.px, self.py, self.heading = s[0], s[1], math.degrees(s[2])
        to_rpm = 60 / (2 * math.pi * r)
        self.wheelR = (s[3] + half * s[4]) * to_rpm
        self.wheelL = (s[3] - half * s[4]) * to_rpm
        return True
'''
PLANT = _ROBOT.format(name="TheirRobot", failure="")
FAILING = _ROBOT.format(name="TheirFailure", failure="if t > 0.495: return False")
LOST = _ROBOT.format(name="TheirLoss", failure="if t > 0.49: self.motorR = math.nan")
PLANT_MAP = """
[plant]
step = 0.005
[plant.inputs]
motorR = { terms = { torque_right = 1000.0 }, unit = "N.m" }
motorL = { terms = { torque_left = 1000.0 }, unit = "N.m" }
[plant.outputs]
x = { terms = { px = 1.0 }, unit = "m" }
y = { terms = { py = 1.0 }, unit = "m" }
psi = { terms = { heading = 1.0 }, unit = "deg" }
w_right = { terms = { wheelR = 1.0 }, unit = "rpm" }
w_left = { terms = { wheelL = 1.0 }, unit = "rpm" }
"""
CONTROLLER = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class TheirController(Fmi2Slave):
    """Holds both wheels at 3 rad/s by a force at each wheel's rim, in N."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.speedR = self.speedL = self.forceR = self.forceL = 0.0
        for name in ("speedR", "speedL"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("forceR", "forceL"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, t, h):
        self.forceR = 200.0 * (3.0 - self.speedR) + 20.0
        self.forceL = 200.0 * (3.0 - self.speedL) + 20.0
        return True
'''
CONTROLLER_MAP = """
[controller.inputs]
speedR = { terms = { w_right = 1.0 }, unit = "rad/s" }
speedL = { terms = { w_left = 1.0 }, unit = "rad/s" }
[controller.outputs]
tau_right = { terms = { forceR = 0.1 }, unit = "N", coefficient_unit = "m" }
tau_left = { terms = { forceL = 0.1 }, unit = "N", coefficient_unit = "m" }
"""
