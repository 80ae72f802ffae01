"""FMUs that several modules try, with the version of FMI; of laws all but two are slow."""

import pytest

both = pytest.mark.parametrize("version", [2, 3])
OTHER_LAWS = [
    pytest.param(law, version, marks=pytest.mark.slow)
    for law, version in (("pid", 2), ("mb", 3), ("kanayama", 2))
]
FMUS = [
    *((what, version) for what in ("plant", "reference", "nn", "guard") for version in (2, 3)),
    ("closed-loop", 2),
    ("closed-loop", 3),
    ("prox", 3),
    *OTHER_LAWS,
]
