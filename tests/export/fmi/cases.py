"""FMUs that several modules try, with the version of FMI; of laws all but two are slow."""

import pytest

OTHER_LAWS = [
    pytest.param("pid", 2, marks=pytest.mark.slow),
    pytest.param("mb", 3, marks=pytest.mark.slow),
    pytest.param("kanayama", 2, marks=pytest.mark.slow),
]
SOME_FMUS = [
    ("plant", 2),
    ("plant", 3),
    ("reference", 2),
    ("reference", 3),
    ("closed-loop", 3),
    ("nn", 2),
    ("nn", 3),
    *OTHER_LAWS,
]
FMUS = [*SOME_FMUS, ("guard", 2), ("guard", 3), ("closed-loop", 2), ("prox", 3)]
