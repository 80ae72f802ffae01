"""XML as a tree."""

import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.robot_files.xml_text import has_macros, numbers, package, tree


def test_names_have_no_address_but_those_of_xacro():
    root = tree('<a xmlns="u" xmlns:xacro="w"><b/><xacro:c/></a>', "a.xml")

    assert [item.tag for item in root.iter()] == ["a", "b", "{w}c"]
    assert has_macros(root)
    assert not has_macros(tree("<a/>", "a.xml"))


@pytest.mark.parametrize(
    "text, words",
    [("<a>", "a.xml is not valid XML: "), ("<!DOCTYPE a><a/>", "a.xml has a DOCTYPE")],
)
def test_what_is_damaged_or_declares_entities_is_refused(text, words):
    with pytest.raises(ScenarioError, match=words):
        tree(text, "a.xml")


@pytest.mark.parametrize("value", ["1 2", "1 2 x", "1 2 1e10", "1 2 nan"])
def test_numbers_are_so_many_of_usual_size_and_zero_where_left_out(value):
    root = tree(f'<a><b xyz="{value}" good="1 -2 3"/></a>', "a.xml")

    assert numbers(root, "b", "good", "here", 3) == (1.0, -2.0, 3.0)
    assert numbers(root, "b", "none", "here", 2) == numbers(root, "c", "d", "here", 2) == (0, 0)
    with pytest.raises(ScenarioError, match=r"here: b xyz = .* must be 3 numbers of usual size"):
        numbers(root, "b", "xyz", "here", 3)


def test_a_package_is_around_the_file_or_beside_its_package(tmp_path):
    for name in ("mine", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "package.xml").write_text(f"<package><name>{name}</name></package>")
    file = tmp_path / "mine" / "urdf" / "robot.xacro"

    assert package("mine", file) == tmp_path / "mine"
    assert package("other", file) == tmp_path / "other"
    with pytest.raises(ScenarioError, match="find third"):
        package("third", file)
