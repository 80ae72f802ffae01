"""Reading of small text files, and which files a command reads and writes."""

import pytest

from wmr_ctrl.core.errors import ResultFileError, ScenarioError
from wmr_ctrl.core.fields.files import (
    decode,
    note_input,
    note_output,
    one_command,
    parse_toml,
    read_text,
)


def test_a_file_is_text_of_its_suffix_and_size(tmp_path):
    file = tmp_path / "a.toml"
    file.write_bytes(b"\xef\xbb\xbfa = 1")

    assert read_text(file, "it", largest=8) == "a = 1"
    with pytest.raises(ScenarioError, match=r"^it: .*a\.toml is larger than 0 MB"):
        read_text(file, "it", largest=7)
    with pytest.raises(ScenarioError, match=r"must end in \.yaml or \.yml"):
        read_text(file, "it", (".yaml", ".yml"))
    with pytest.raises(ScenarioError, match="there is no file"):
        read_text(tmp_path / "b.toml", "it")
    with pytest.raises(ScenarioError, match="is a directory"):
        read_text(tmp_path, "it")


@pytest.mark.parametrize(
    "data, words", [(b"ab\xff", "is not UTF-8 text (byte 3)"), (b"a\0", "it has a byte 0")]
)
def test_what_is_no_text_is_refused(data, words):
    with pytest.raises(ScenarioError) as caught:
        decode(data, "it")
    assert words in str(caught.value)


@pytest.mark.parametrize("read_first", [True, False])
def test_a_command_does_not_write_what_it_reads(tmp_path, read_first):
    file, link = tmp_path / "a", tmp_path / "b"
    file.touch()
    link.symlink_to(file)

    def both():
        for note in (note_input, note_output)[:: 1 if read_first else -1]:
            note(*((file, "run") if note is note_input else (link,)))

    with one_command(), one_command(), pytest.raises(ResultFileError, match=r"\(run: .*Write to"):
        both()
    both()  # outside of a command
    with one_command():
        note_input(file, "run")
        note_output(tmp_path / "c")


def test_toml_that_is_wrong_is_told_with_its_place():
    with pytest.raises(ScenarioError) as caught:
        parse_toml("a = 1\nb = = 2\n", "it", "Mend it.")

    assert str(caught.value).startswith("it is not valid TOML: ")
    assert str(caught.value).endswith(" (at line 2, column 5). Mend it.")
    with pytest.raises(ScenarioError, match="nested too deeply"):
        parse_toml("a = " + "[" * 5000 + "]" * 5000, "it")
