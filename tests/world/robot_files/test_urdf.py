"""Mass, inertia, wheels and track of a URDF."""

import math
import random

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.robot_files import urdf
from wmr_ctrl.world.robot_files.read import read_robot_files
from wmr_ctrl.world.robot_files.xml_text import tree


def turn(rpy):
    """Rotation about fixed x, then y, then z."""
    return Rotation.from_euler("xyz", rpy).as_matrix()


def text(values):
    return " ".join(repr(float(value)) for value in values)


def origin(xyz, rpy):
    return f'<origin xyz="{text(xyz)}" rpy="{text(rpy)}"/>'


def inertial(masses, points, rpy):
    """The inertial of point masses, stated in a frame that is turned by ``rpy``."""
    centre, about = masses @ points / masses.sum(), np.zeros((3, 3))
    for mass, at in zip(masses, (points - centre) @ turn(rpy), strict=True):
        about += mass * (at @ at * np.eye(3) - np.outer(at, at))
    rows, columns = np.triu_indices(3)
    stated = zip(("xx", "xy", "xz", "yy", "yz", "zz"), about[rows, columns], strict=True)
    entries = " ".join(f'i{name}="{float(value)!r}"' for name, value in stated)
    mass = f'<mass value="{masses.sum()}"/>'
    return f"<inertial>{origin(centre, rpy)}{mass}<inertia {entries}/></inertial>"


def joined(parent, child):
    return (
        f'<joint name="{parent}{child}" type="fixed"><parent link="{parent}"/>'
        f'<child link="{child}"/></joint>'
    )


def wheel(name, x, y, radius=0.1, parent="base", **attributes):
    kind = attributes.get("kind", "continuous")
    return (
        f'<link name="{name}"><collision><geometry><cylinder radius="{radius}" length="0.02"/>'
        f'</geometry></collision></link><joint name="{name}_joint" type="{kind}">'
        f'<parent link="{parent}"/><child link="{name}"/>{origin((x, y, 0), (-math.pi / 2, 0, 0))}'
        '<axis xyz="0 0 1"/></joint>'
    )


def robot(*parts):
    return f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>'


def read(tmp_path, *texts, name="robot{}.urdf"):
    files = [tmp_path / name.format(i) for i in range(len(texts))]
    for file, content in zip(files, texts, strict=True):
        file.write_text(content, encoding="utf-8")
    return read_robot_files(files)


@pytest.mark.parametrize("seed", range(30))
def test_inertia_is_that_of_all_point_masses_about_the_axle(seed, tmp_path):
    rng = np.random.default_rng(seed)
    x, y, mass, inertia = rng.uniform(-1, 1), rng.uniform(0.05, 1), 0.0, 0.0
    links, parts = [("base", np.eye(3), np.zeros(3))], []
    for i in range(rng.integers(1, 9)):
        above, outer, place = links[rng.integers(len(links))]
        xyz, rpy = rng.uniform(-1, 1, 3), rng.uniform(-3, 3, 3)
        links.append((f"link{i}", outer @ turn(rpy), place + outer @ xyz))
        masses, points = rng.uniform(0.1, 5, 4), rng.uniform(-1, 1, (4, 3))
        far = links[-1][2] + points @ links[-1][1].T - [x, 0, 0]
        mass, inertia = mass + masses.sum(), inertia + masses @ (far[:, :2] ** 2).sum(axis=1)
        kind = rng.choice(["fixed", "revolute", "prismatic"])
        parts.append(
            f'<link name="link{i}">{inertial(masses, points, rng.uniform(-3, 3, 3))}</link>'
            f'<joint name="j{i}" type="{kind}"><parent link="{above}"/><child link="link{i}"/>'
            f"{origin(xyz, rpy)}</joint>"
        )
    rng.shuffle(parts)

    found = read(tmp_path, robot(*parts, wheel("left", x, y), wheel("right", x, -y))).found

    wanted = {"robot.I": inertia, "robot.m": mass, "robot.l": y, "robot.r": 0.1}
    assert {key: found[key].value for key in wanted} == pytest.approx(wanted, rel=1e-5)


def test_four_wheels_drive_and_casters_do_not(tmp_path):
    sides = [("front_left", 0.3, 0.2), ("front_right", 0.3, -0.2)]
    sides += [("rear_left", -0.1, 0.2), ("rear_right", -0.1, -0.2)]
    casters = [wheel("caster_left", 0.5, 0.3, 0.04), wheel("caster_right", 0.5, -0.3, 0.04)]
    body = inertial(np.ones(2), np.array([[0.1, 1.0, 0], [0.1, -1.0, 0]]), (0, 0, 0))
    box = f'<link name="box">{body}</link>{joined("base", "box")}'

    found = read(tmp_path, robot(*casters, *(wheel(*side) for side in sides), box)).found

    assert found["robot.l"].value == 0.2
    assert found["robot.r"].value == 0.1
    assert found["robot.I"].value == 2.0, "the box is in the middle of the four wheels"
    assert "(not caster_left_joint, caster_right_joint)" in found["robot.l"].source


def test_wheels_that_are_steered_drive_no_side(tmp_path):
    """Casters larger than the driven wheels, and the front wheels of a car."""
    for x in (0.2, 0.3):
        turned = [
            f'<link name="{side}"/><joint name="{side}_turns" type="{kind}"><parent link="base"/>'
            f'<child link="{side}"/>{origin((0.5, y, 0), (0, 0, 0))}<axis xyz="0 0 1"/></joint>'
            f'<link name="{side}_fork"/>{joined(side, side + "_fork")}'
            + wheel(f"{side}_wheel", -x, 0, x, f"{side}_fork")
            for side, y, kind in (("left", 0.4, "continuous"), ("right", -0.4, "revolute"))
        ]
        found = read(tmp_path, robot(*turned, PAIR)).found
        assert (found["robot.l"].value, found["robot.r"].value) == (0.2, 0.1)


PAIR = wheel("l", 0, 0.2) + wheel("r", 0, -0.2)
NEGATIVE = '<link name="b"><inertial><mass value="-1"/></inertial></link>' + joined("base", "b")
CIRCLE = '<link name="a"/><link name="b"/>' + joined("a", "b") + joined("b", "a")
BOMB = '<!DOCTYPE robot [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>'
OUTSIDE = '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot>&x;</robot>'
MACROS = '<robot xmlns:xacro="http://ros.org/wiki/xacro">{}</robot>'
FAULTS = {
    "no pair of wheels": robot(wheel("l", 0, 0.2), wheel("r", 0.1, -0.2)),
    "no pair": robot(wheel("l", 0, 0.2), wheel("r", 0, 0.2)),
    "wheels": robot(wheel("l", 0, 0), wheel("r", 0, 0)),
    "must be 3 numbers of usual size": robot(PAIR).replace("0.2 0.0", "nan 0.0"),
    "must not be below 0": robot(PAIR, NEGATIVE),
    "two have the same": robot(PAIR, PAIR),
    "must join two links": robot(PAIR).replace('child link="l"', 'child link="nobody"'),
    "have no joint above them": robot(PAIR, '<link name="lost"/>'),
    "circle of joints": robot(PAIR, CIRCLE),
    "must be a number of usual size": robot(PAIR).replace('radius="0.1"', 'radius="wide"'),
    "is not valid XML": robot(PAIR)[:200],
    "is of no known kind": "<robot/>",
    "DOCTYPE": BOMB + robot(PAIR),
    "DOCTYPE, which": OUTSIDE,
    "cannot be expanded by xacro": MACROS.format("<xacro:none/>"),
    "$(find nowhere)": MACROS.format('<xacro:include filename="$(find nowhere)/x"/>'),
    "xacro": MACROS.format('<xacro:if value="${1/0}"/>'),
}


def assert_refused(tmp_path, text, words, name):
    with pytest.raises(ScenarioError) as caught:
        read(tmp_path, text, name=name)
    assert words in str(caught.value)
    assert name.format(0) in str(caught.value)


def times_refused(tmp_path, whole, pieces, name):
    """Return how many of 300 files are refused after a random place is cut or altered."""
    chance, refused = random.Random(0), 0
    for _ in range(300):
        place = chance.randrange(len(whole))
        text = whole[:place] + chance.choice(pieces) + whole[place + chance.randrange(9) :]
        try:
            read(tmp_path, text, name=name)
        except ScenarioError:
            refused += 1
    return refused


@pytest.mark.parametrize("words", FAULTS)
def test_faulty_file_is_refused_in_words(words, tmp_path):
    assert_refused(tmp_path, FAULTS[words], words, "robot{}.urdf")


def test_every_cut_and_altered_file_is_read_or_refused(tmp_path):
    pieces = ["", "nan", "-1e308", '"', "<", "ü\u2028", "${", robot(PAIR)]
    assert 100 < times_refused(tmp_path, robot(PAIR), pieces, "robot{}.urdf") < 300


def test_wheels_are_found_by_the_joints_that_a_controller_names():
    turned = wheel("lidar", 0.3, 0.0, radius=0.03)
    root = tree(robot(wheel("a", 0.0, 0.3), wheel("b", 0.0, -0.3), turned), "robot.urdf")

    found = {item.key: item.value for item in urdf.read(root, "robot.urdf", ["a_joint", "b_joint"])}

    assert found["robot.r"] == pytest.approx(0.1)
    assert found["separation"] == pytest.approx(0.6)
