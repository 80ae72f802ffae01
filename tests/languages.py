"""Compilers and language standards that the project's C supports."""

import shutil
import subprocess

import pytest

STRICT = "-Wall -Wextra -Wpedantic -Wconversion -Werror"
LANGUAGES = {
    "g++-c++98": f"g++ -x c++ -std=c++98 {STRICT}",
    "gcc-c99": f"gcc -std=c99 {STRICT}",
    "gcc-c11": f"gcc -std=c11 {STRICT}",
    "clang-c99": f"clang -std=c99 {STRICT}",
    "clang-c11": f"clang -std=c11 {STRICT}",
    "g++-c++11": f"g++ -x c++ -std=c++11 {STRICT}",
    "clang++-c++98": f"clang++ -x c++ -std=c++98 {STRICT}",
    "clang++-c++11": f"clang++ -x c++ -std=c++11 {STRICT}",
    "tcc": "tcc -Wall -Werror",
}
"""Name to command.  Nothing is optimised: what is asked is whether it is the language at all."""


def compile_all(language, folder, units, *flags):
    """Compile each unit in ``folder``; skip with a reason if the compiler is missing."""
    command = LANGUAGES[language].split()
    if shutil.which(command[0]) is None:
        pytest.skip(f"NOT RUN: {command[0]} is not there")
    whole = [*command, *flags, "-fsyntax-only", *units]
    one_by_one = [[*command, *flags, "-c", unit, "-o", "unit.o"] for unit in units]
    for each in one_by_one if language == "tcc" else [whole]:
        done = subprocess.run(each, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-3000:]
