"""The list of figures, and that each gives the same file each time."""

import string

import matplotlib as mpl
import pytest

from benchmarks.paper_figures import PANELS, all_drawings

EVIDENCE = ("measure", "limits_all_seeds", "stress_velocities")


@pytest.fixture(scope="session")
def drawings(campaign):
    return {drawing.name: drawing for drawing in all_drawings(campaign)}


def test_every_panel_of_both_figures_is_there(drawings):
    wanted = [f"fig{n}{p.letter}_{p.key}" for n in (3, 5) for p in PANELS]

    assert [panel.letter for panel in PANELS] == list(string.ascii_lowercase[:12])
    assert set(drawings) == {*wanted, *EVIDENCE}


def test_a_users_settings_neither_matter_nor_change(drawings, tmp_path):
    (before,) = drawings["fig3h_distance"].save(tmp_path, (".svg",))
    plain = before.read_bytes()
    with mpl.rc_context({"axes.grid": False, "font.size": 30}):
        (after,) = drawings["fig3h_distance"].save(tmp_path, (".svg",))

        assert mpl.rcParams["font.size"] == 30
    assert after.read_bytes() == plain
