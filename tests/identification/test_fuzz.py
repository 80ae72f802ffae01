"""Whatever a table or a bag holds, it is a log or an error in one paragraph."""

import json
import math
import random

import pytest
from rosbags.rosbag2 import StoragePlugin

from tests.results.test_bag_topics import EPOCH, TYPES, bag, header, joints, odometry, twist
from wmr_ctrl import identify
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.results.bag import JOINTS, ODOMETRY, STAMPED, TWIST

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

HEADS = {
    "velocity": "t [s],v_command [m/s],omega_command [rad/s],v1 [m/s],omega [rad/s]",
    "torque": "t [s],tau_right [N.m],tau_left [N.m],wheel_counts[1],wheel_counts[2]",
}
PLUGINS = tuple(StoragePlugin)
KNOWN = {"robot.r": 0.08, "robot.l": 0.2, "encoder.counts": 4096}
ODD = [
    "", "nan", "inf", "-1e308", "1e999", "0", '"', ";", "\t", "#", "x", "1,5", "[", "\0", "\n",
    "9223372036854775807", "1e15", "-0", "0x1p3", "1_000", "٣", "t", "%",
]  # fmt: skip
NUMBERS = ["", "0", "nan", "-0", "0.3", "-5", "1e-9", "123.456", "1e4"]
SIZES = [math.nan, math.inf, -1e308, 1e15, 1e-320, *[0.0, -7.0, 5.0] * 3]


def moved(draw, seconds, step):
    """Times, commands and speeds (v, omega) of a base that follows random steps."""
    rows, sent, speed = [], [0.0, 0.0], [0.0, 0.0]
    for k in range(round(seconds / step)):
        if k % max(1, round(0.5 / step)) == 0:
            sent = [draw.uniform(-1, 1), draw.uniform(-1, 1)]
        speed = [v + 0.3 * (u - v) + draw.gauss(0, 0.01) for v, u in zip(speed, sent, strict=True)]
        rows.append((k * step, *sent, *speed))
    return rows


def table(draw, base):
    """Lines of a table of a base."""
    if base == "velocity":
        rows = [[repr(round(x, 4)) for x in row] for row in moved(draw, 4.0, 0.05)]
    else:
        rows, turned = [], [0.0, 0.0]
        for t, right, left, v, omega in moved(draw, 11.0, 0.1):
            turned = [
                a + 800 * (v + side * omega) for a, side in zip(turned, (0.2, -0.2), strict=True)
            ]
            rows.append([f"{t:.3f}", f"{right:.3f}", f"{left:.3f}", *(f"{x:.0f}" for x in turned)])
    return [HEADS[base].split(","), *rows]


def spoilt_table(draw, base):
    """Bytes of a table in which cells, lines, columns or bytes are others."""
    rows = table(draw, base)
    width = len(rows[0])
    odd = draw.choice([NUMBERS, NUMBERS, ODD])
    for _ in range(draw.choice([0, 0, 1, 2, 5])):
        draw.choice(rows[draw.choice([0, 1, 1]) :])[draw.randrange(width)] = draw.choice(odd)
    if draw.random() < 0.2:
        place, value = draw.randrange(width), draw.choice(["", "0", "1e-320", "1e300", "7"])
        for row in rows[draw.choice([0, 1, 1, 40]) :]:
            row[place] = value
    if draw.random() < 0.2:
        place = draw.randrange(width)
        factor = draw.choice([-1, 1e-3, 1e3, 57.3, 1e12])
        for row in rows[1:]:
            if row[place].replace(".", "").isdigit():
                row[place] = repr(factor * float(row[place]))
    if draw.random() < 0.03:
        draw.shuffle(rows)
    separator = draw.choice([*[","] * 6, ";", "\t", " "])
    lines = [separator.join(row) for row in rows]
    for _ in range(draw.choice([0, 0, 0, 1, 3])):
        at, other = draw.randrange(len(lines)), draw.randrange(len(lines))
        lines[at] = draw.choice(["", lines[other], lines[at][:7], lines[at] * 2])
    end = draw.choice(["\n", "\n", "\r\n", "\r"])
    coding = draw.choice([*["utf-8"] * 5, "utf-8-sig", "latin-1", draw.choice(["utf-8", "utf-16"])])
    data = end.join(lines).encode(coding, "replace")
    return altered(draw, data) if draw.random() < 0.2 else data


def altered(draw, data):
    """Bytes that are cut, empty or changed in some places."""
    kind = draw.randrange(4)
    if kind == 0:
        return data[: draw.randrange(len(data) + 1)]
    if kind == 1:
        at = draw.randrange(len(data))
        return data[:at] + data[at + draw.randrange(200) :]
    new = bytearray(data)
    for _ in range(draw.randrange(1, 20)):
        new[draw.randrange(len(new))] = draw.choice([0, 255, 10, 44, draw.randrange(256)])
    return bytes(new)


def odd_time(draw, t):
    return draw.choice([t, t, t, -t, 0.0, t + 1e3, 2.1e9])


def messages(draw):
    """Messages of a base, some of them odd."""
    share = draw.choice([0.0, 0.0, 0.0, 0.002, 0.01, 0.3])
    kinds = draw.choice([("odom",), ("cmd",), ("joints",), *[("odom", "cmd")] * 4,
                         ("odom", "cmd", "joints"), ("cmd", "joints")])  # fmt: skip
    named = draw.choice([("base_right_wheel", "base_left_wheel"), ("a", "b"), ("right",), ()])
    stamped = draw.random() < 0.5
    way, rows = [0.0, 0.0], []
    for t, v, omega, seen, turned in moved(draw, draw.choice([0.0, 1.0, *[4.0] * 6]), 0.05):
        now = EPOCH + t

        def odd(value):
            return draw.choice(SIZES) if draw.random() < share else value

        def at(now=now):
            return max(odd_time(draw, now) if draw.random() < share else now, 0.0)

        way = [a + 0.05 * x for a, x in zip(way, (seen + turned, seen - turned), strict=True)]
        if "odom" in kinds:
            said = odometry(at(), odd(seen), odd(turned), (odd(way[0]), odd(t), way[1]),
                            frame=draw.choice(["odom", "map"]) if share else "odom",
                            norm=odd(1.0), sideways=odd(0.0))  # fmt: skip
            rows.append(("/odom", ODOMETRY, at(), said))
        if "cmd" in kinds:
            said = twist(odd(v), odd(omega))
            if stamped:
                said = TYPES[STAMPED](header=header(at()), twist=said)
            rows.append(("/cmd_vel", STAMPED if stamped else TWIST, at(), said))
        if "joints" in kinds:
            count = len(named) if draw.random() > share else draw.randrange(4)
            numbers = [[odd(x) for x in (*way, 0.0, 0.0)[:count]] for _ in range(3)]
            rows.append(("/joint_states", JOINTS, at(), joints(at(), *numbers, names=named)))
    if draw.random() < 0.1:
        return [(draw.choice(["/odom", "/cmd_vel"]), *row[1:]) for row in rows]
    return rows


def spoilt_bag(draw, folder):
    """Path of a bag with odd messages, or of which files are altered."""
    folder.mkdir()
    place = bag(folder, messages(draw), draw.choice([*PLUGINS]))
    files = sorted(place.iterdir())
    if draw.random() < 0.35:
        file = draw.choice(files)
        file.write_bytes(altered(draw, file.read_bytes() or b"\0"))
    if draw.random() < 0.2:
        return draw.choice(files)
    return place


def outcome(path, draw, base):
    """Whether a file is read; the error's text if not."""
    try:
        found = identify(path, base=base, overrides=KNOWN)
    except WmrError as problem:
        return str(problem)
    json.dumps(found.to_json())
    assert found.to_toml()
    return ""


@pytest.mark.parametrize(
    "tables, bags",
    [(range(40), range(30)),
     pytest.param(range(40, 240), range(30, 130), marks=pytest.mark.slow)],
)  # fmt: skip
def test_a_file_of_any_kind_is_a_log_or_an_error_in_one_paragraph(tmp_path, tables, bags):
    said = []
    for seed in tables:
        draw = random.Random(seed)
        base = draw.choice(["velocity", "velocity", "velocity", "torque"])
        place = tmp_path / f"log{draw.choice(['.csv', '.tsv', '.txt'])}"
        place.write_bytes(spoilt_table(draw, base))
        said.append(outcome(place, draw, base))
    for seed in bags:
        draw = random.Random(f"bag {seed}")
        place = spoilt_bag(draw, tmp_path / str(seed))
        said.append(outcome(place, draw, draw.choice(["velocity", "velocity", "torque"])))
    assert not [text for text in said if "\n" in text]
    assert 0.05 * len(said) < said.count("") < 0.9 * len(said)
