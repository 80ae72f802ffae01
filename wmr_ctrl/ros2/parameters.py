"""Parameters of the nodes, which parameters.toml lists."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ArgumentError

Default: TypeAlias = str | float | bool | list[float] | list[str]


@dataclass(frozen=True)
class Declared:
    """A parameter: default, description, and valid values, from parameters.toml.

    ``many``: a list of any length.
    """

    default: Default
    text: str
    rule: str = ""
    range: Sequence[float] = ()
    choices: Sequence[str] = ()
    many: bool = False

    @property
    def constraints(self) -> str:
        """Text of the rule for its values."""
        return f"one of {', '.join(self.choices)}" if self.choices else self.rule

    def chosen(self, name: str, value: str) -> str:
        """The value; raises ArgumentError if there are choices and it is not one of them."""
        if self.choices and value not in self.choices:
            raise ArgumentError(f"{name} = {value!r} must be one of {', '.join(self.choices)}.")
        return value


Table: TypeAlias = dict[str, Declared]
_TABLES: dict[str, Table] = {
    part: {name: Declared(**row) for name, row in rows.items()}
    for part, rows in data(__package__, "parameters.toml").items()
}
SIGHT = _TABLES["sight"]
"""Parameters of ``wmr_filter`` about changing limits and obstacles."""
FILTER, DRIVE = _TABLES["filter"] | SIGHT | _TABLES["shared"], _TABLES["drive"] | _TABLES["shared"]
"""Parameters of ``wmr_filter`` and of ``wmr_drive``."""
CHANGING = _TABLES["changing"]
"""Further ones of ``wmr_filter``, which may change while it drives."""
SPEED_SCALE = "speed_scale"
