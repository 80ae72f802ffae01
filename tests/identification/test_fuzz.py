"""Whatever a table holds, it is a log or an error in words."""

import random

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.identification.logs import lint
from wmr_ctrl.identification.logs.log import COMMAND, log_of
from wmr_ctrl.identification.logs.mended import mended
from wmr_ctrl.identification.logs.rows import usable
from wmr_ctrl.identification.logs.samples import motion_of

HEAD = "t [s],v_command [m/s],omega_command [rad/s],v1 [m/s],omega [rad/s]"
ODD = ["", "nan", "inf", "-1e308", "1e999", "0", '"', ";", "\t", "#", "x", "1,5", "[", "\0", "\n"]


def spoilt(seed):
    """A table of 80 rows in which some cells, lines or characters are others."""
    draw = random.Random(seed)
    rows = [
        [repr(round(draw.uniform(-1, 1), draw.randrange(4))) for _ in range(4)] for _ in range(80)
    ]
    lines = [HEAD, *(",".join([repr(0.05 * k), *row]) for k, row in enumerate(rows))]
    for _ in range(draw.randrange(6)):
        at = draw.randrange(len(lines))
        cells = lines[at].split(",")
        cells[draw.randrange(len(cells))] = draw.choice(ODD)
        lines[at] = ",".join(cells)
    for _ in range(draw.randrange(3)):
        at, other = draw.randrange(len(lines)), draw.randrange(len(lines))
        lines[at] = draw.choice(["", lines[other], lines[at][:7], lines[at] * 2])
    if draw.random() < 0.3:
        column = draw.randrange(5)
        value = draw.choice(["", "0", "1e-320", "1e300"])
        lines[1:] = [
            ",".join(value if k == column else cell for k, cell in enumerate(line.split(",")))
            for line in lines[1:]
        ]
    return "\n".join(lines)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    "seeds", [range(60), pytest.param(range(60, 2060), marks=pytest.mark.slow)]
)  # fmt: skip
def test_a_table_of_any_kind_is_a_log_or_an_error_in_one_paragraph(tmp_path, seeds):
    place, read, told = tmp_path / "log.csv", 0, []
    for seed in seeds:
        place.write_text(spoilt(seed))
        try:
            log = mended(log_of(place))
            lint.check_times(log)
            lint.check_counters(log)
            usable(motion_of(log, paper(), "v1", COMMAND))
            read += 1
        except WmrError as problem:
            told.append(str(problem))
    assert not [text for text in told if "\n" in text]
    assert 0.03 * len(seeds) < read < 0.9 * len(seeds)
