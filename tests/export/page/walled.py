"""A base that is told to drive through a wall, behind a filter that stops."""

from wmr_ctrl.world.scenario import loads_scenario

WALLED = """
title = "It stops in time"
[robot]
m = 30.0
I = 1.5
mu = 0.0
r = 0.08
l = 0.2
[base]
kind = "velocity"
tau = [0.28, 0.28]
gain = [1.05, 1.0]
delay = 0.1
[body]
radius = 0.25
[limits]
v_u1 = [1.0, 2.0]
[clock]
control = 0.05
duration = 6.0
[filter]
kind = "governor"
tau = [0.15, 0.3]
gain = [0.9, 1.1]
d = [0.05, 0.05]
odometry = [0.02, 0.02]
delay = [0.1, 0.15]
changing = true
free_error = 0.02
rest = 1.0
[world]
wall = [[3.0, -1.0], [3.0, 1.0]]
[reference]
kind = "line"
speed = 0.8
[disturbance]
std = 0.0
"""


def walled():
    return loads_scenario(WALLED, "wall")
