"""Any table or bag is read as a log, or gives an error of one paragraph."""

import json
import math
import random

import pytest
from rosbags.rosbag2 import StoragePlugin

from tests.identification.conftest import drive
from tests.results.test_bag_topics import EPOCH, bag, joints, odometry, twist
from wmr_ctrl import identify
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.results.bag import JOINTS, ODOMETRY, TWIST

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

KNOWN = {"robot.r": 0.08, "robot.l": 0.2, "encoder.counts": 4096}
BASES = ("velocity", "velocity", "torque")
HEADS = {
    "velocity": "t [s],v_command [m/s],omega_command [rad/s],v1 [m/s],omega [rad/s]",
    "torque": "t [s],tau_right [N.m],tau_left [N.m],wheel_counts[1],wheel_counts[2]",
}
ODD = [
    "", "nan", "inf", "-1e308", "1e999", "0", '"', ";", "\t", "#", "x", "1,5", "[", "\0", "\n",
    "9223372036854775807", "1e15", "-0", "0x1p3", "1_000", "٣", "t", "%",
]  # fmt: skip
NUMBERS = ["", "0", "nan", "-0", "0.3", "-5", "1e-9", "123.456", "1e4"]
SIZES = [math.nan, math.inf, -1e308, 1e15, 1e-320, *[0.0, -7.0, 5.0] * 3]


def driven(draw, seconds):
    """Rows of t, commands and speeds (v, omega); counts of wheels are a thousand times the way."""
    log = drive(seed=draw.randrange(10**6), seconds=seconds, period=0.05)
    way, rows = [0.0, 0.0], []
    for t, v, omega, seen, turned in zip(*log.values(), strict=True):
        way = [a + 0.05 * x for a, x in zip(way, (seen + turned, seen - turned), strict=True)]
        rows.append((t, v, omega, seen, turned, way))
    return rows


def spoilt_table(draw, base):
    """Bytes of a table with altered cells, lines, columns or bytes."""
    rows = [HEADS[base].split(",")]
    for t, v, omega, seen, turned, way in driven(draw, 4.0 if base == "velocity" else 11.0):
        last = (seen, turned) if base == "velocity" else (1000 * x // 1 for x in way)
        rows.append([repr(round(x, 4)) for x in (t, v, omega, *last)])
    odd = draw.choice([NUMBERS, NUMBERS, ODD])
    for _ in range(draw.choice([0, 0, 1, 2, 5])):
        draw.choice(rows[draw.choice([0, 1, 1]) :])[draw.randrange(5)] = draw.choice(odd)
    if draw.random() < 0.2:
        place, value = draw.randrange(5), draw.choice(["", "0", "1e-320", "1e300", "7"])
        for row in rows[draw.choice([0, 1, 1, 40]) :]:
            row[place] = value
    separator = draw.choice([*[","] * 6, ";", "\t", " "])
    lines = [separator.join(row) for row in rows]
    for _ in range(draw.choice([0, 0, 0, 1, 3])):
        at, other = draw.randrange(len(lines)), draw.randrange(len(lines))
        lines[at] = draw.choice(["", lines[other], lines[at][:7], lines[at] * 2])
    coding = draw.choice([*["utf-8"] * 5, "utf-8-sig", "latin-1", "utf-16"])
    data = draw.choice(["\n", "\n", "\r\n", "\r"]).join(lines).encode(coding, "replace")
    return altered(draw, data) if draw.random() < 0.2 else data


def altered(draw, data):
    """Bytes that are cut, empty or changed in some places."""
    new = bytearray(data)
    if draw.random() < 0.5:
        at = draw.randrange(len(data))
        del new[at : at + draw.choice([len(data), draw.randrange(200)])]
        return bytes(new)
    for _ in range(draw.randrange(1, 20)):
        new[draw.randrange(len(new))] = draw.choice([0, 255, 10, 44, draw.randrange(256)])
    return bytes(new)


def spoilt_bag(draw, folder):
    """Write a bag with odd messages or an altered file, and return a path to it."""
    share, rows = draw.choice([0.0, 0.0, 0.002, 0.3]), []

    def odd(value, others=SIZES):
        return draw.choice(others) if draw.random() < share else value

    for t, v, omega, seen, turned, way in driven(draw, draw.choice([0.05, 4.0, 4.0, 4.0])):
        now = EPOCH + odd(t, [-t, 1e3, 0.0])
        pose = (odd(way[0]), odd(t), way[1])
        moved = odometry(now, odd(seen), odd(turned), pose, norm=odd(1.0), sideways=odd(0.0))
        rows.append(("/odom", ODOMETRY, now, moved))
        rows.append(("/cmd_vel", TWIST, now, twist(odd(v), odd(omega))))
        if share:
            rows.append(("/joint_states", JOINTS, now, joints(now, [odd(x) for x in way])))
    folder.mkdir()
    place = bag(folder, rows, draw.choice([*StoragePlugin]))
    files = sorted(place.iterdir())
    if draw.random() < 0.35:
        file = draw.choice(files)
        file.write_bytes(altered(draw, file.read_bytes() or b"\0"))
    return draw.choice(files) if draw.random() < 0.2 else place


def outcome(path, draw):
    """The error's text; "" for a file that is read."""
    try:
        found = identify(path, base=draw.choice(BASES), overrides=KNOWN)
    except WmrError as problem:
        return str(problem)
    json.dumps(found.to_json())
    assert found.to_toml()
    return ""


@pytest.mark.parametrize(
    "tables, bags",
    [(range(20), range(20)),
     pytest.param(range(20, 240), range(20, 130), marks=pytest.mark.slow)],
)  # fmt: skip
def test_a_file_of_any_kind_is_a_log_or_an_error_in_one_paragraph(tmp_path, tables, bags):
    said = []
    for seed in tables:
        draw = random.Random(seed)
        place = tmp_path / f"log{draw.choice(['.csv', '.tsv', '.txt'])}"
        place.write_bytes(spoilt_table(draw, draw.choice(BASES)))
        said.append(outcome(place, draw))
    for seed in bags:
        draw = random.Random(f"bag {seed}")
        said.append(outcome(spoilt_bag(draw, tmp_path / str(seed)), draw))
    assert not [text for text in said if "\n" in text]
    assert 0.05 * len(said) < said.count("") < 0.9 * len(said)
