"""The quick compiler gets the code that it compiles correctly, the compiler from PATH the rest."""

import os
import subprocess

import pytest

from tests.conftest import QUICK

PLAIN = "double twice(double x) { return 2.0 * x; }\n"
VECTORS = (
    "typedef double two __attribute__((vector_size(16)));\ntwo twice(two x) { return x + x; }\n"
)


@pytest.mark.skipif(not QUICK, reason="NOT RUN: tcc is not there")
@pytest.mark.parametrize(
    "text, level, quick",
    [(PLAIN, "-O0", True), (PLAIN, "-O1", False), (VECTORS, "-O0", False)],
)
def test_a_library_that_is_not_optimised_and_has_no_vectors_is_made_quickly(
    tmp_path, text, level, quick
):
    (tmp_path / "a.c").write_text(text, encoding="utf-8")
    command = [os.path.join(QUICK, "cc"), "-O3", "-shared", "-fPIC", level, "a.c", "-o", "a.so"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    assert (b"GCC: (" in (tmp_path / "a.so").read_bytes()) != quick
