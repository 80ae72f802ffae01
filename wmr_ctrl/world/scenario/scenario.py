"""Scenario: all inputs of a run except the law, checked and immutable."""

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias, TypeVar, cast

from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError, show
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.named_units import Stated, with_units
from wmr_ctrl.core.fields.orientation import PAPER, checked_frames, described, field_outward
from wmr_ctrl.core.fields.section import Section, number_of, numbers_in, quantities
from wmr_ctrl.core.fields.unstated import Unknown, Unstated
from wmr_ctrl.core.fields.values import Frozen, Quantity, Range, as_list, check_multiple
from wmr_ctrl.core.late_bound import late_bound
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.results.frames import table_html
from wmr_ctrl.results.obstacles import Shape
from wmr_ctrl.world.references import REFERENCES, Reference
from wmr_ctrl.world.references.kind import ReferenceKind
from wmr_ctrl.world.registry import EFFECTS, Actuator, Base, Disturbance, Sensor

from .command_filter import Filter
from .sections import (
    Body,
    Change,
    Clock,
    CorridorSettings,
    Guard,
    Initial,
    Limits,
    Metrics,
    Model,
    Robot,
    Ros,
    World,
)
from .unstated import KIND, following, missing_keys, missing_text

Gain: TypeAlias = float | bool | str | tuple[float, ...]
Gains: TypeAlias = Mapping[str, Mapping[str, Gain]]

_NUMBER = Quantity(None, "", "a gain", Range(), "number")


def clean_gains(raw: object) -> Gains:
    """Return gains with numbers as floats and arrays as tuples of floats, hashable.

    Raises ScenarioError for anything that is not a table of tables of numbers, arrays of
    numbers, texts or flags.
    """
    if not isinstance(raw, Mapping):
        raise ScenarioError(f"gains = {show(raw)} must be a table of laws, as in [gains.mb].")
    laws = {}
    for law, gains in raw.items():
        path = f"gains.{law}"
        if not isinstance(gains, Mapping):
            raise ScenarioError(f"{path} = {show(gains)} must be a table of gains, as in [{path}].")
        named = ((str(name), _gain(value, f"{path}.{name}")) for name, value in gains.items())
        laws[str(law)] = Frozen(named)
    return Frozen(laws)


def _gain(value: object, path: str) -> Gain:
    """A gain; one that is written with its unit keeps it until the law's gains are built."""
    value = with_units(value)
    if isinstance(value, Stated):
        return value
    if isinstance(value, (bool, str)):
        return value
    items = as_list(value)
    if items is None:
        number: float = _NUMBER.clean(value, path)
        return number
    return tuple(
        item if isinstance(item, Stated) else _NUMBER.clean(item, f"{path}[{i}]")
        for i, item in enumerate(items, start=1)
    )


class MissingKeysError(ScenarioError):
    """Keys that a scenario needs and does not state, in one message."""


ROUNDING = 1e-9
"""Share by which a difference of two times may miss a third."""
S = TypeVar("S", bound=Section)


def sections() -> dict[str, type[Section]]:
    """All tables that are one dataclass each: SECTIONS, and those of effects with their own."""
    own = EFFECTS.sections()
    if taken := own.keys() & {*SECTIONS, *OTHER_KEYS, "extends"}:
        raise ArgumentError(
            f"an effect of another package uses the table {sorted(taken)[0]!r}, which a scenario "
            "already has. The author of the effect must give its section another KEY."
        )
    return {**SECTIONS, **own}


@dataclass(frozen=True, kw_only=True, repr=False)
class Scenario:
    """A robot, its laws' model, limits, gains, a start, a reference, and disturbances.

    It must state limits.v_u1, a reference, and the robot's numbers that its base needs
    (`unstated`); all other defaults belong to no robot.  SI units.  ``gains`` holds the stated
    gains, by law and gain; numbers are floats, arrays tuples of floats.  A law's other gains are
    the law's own defaults.  ``effects`` holds the sections of effects that have their own table, by
    its key; see `section`.  ``frames`` says how files, tables and runs state orientations: "paper"
    (0 along +Y) or "rep103" (0 along +X).  The fields here follow the paper in either case.
    ``assumed`` names keys, such as "limits.v_u1", whose values nobody stated.  ``law`` is the law
    to use if a caller names none; see `wmr_ctrl.control.given.default_law`.
    """

    name: str = "unnamed"
    title: str = ""
    law: str | None = None
    frames: str = PAPER
    assumed: tuple[str, ...] = ()
    robot: Robot = field(default_factory=Robot)
    body: Body = field(default_factory=Body)
    model: Model = field(default_factory=Model)
    limits: Limits = field(default_factory=Limits)
    gains: Gains = field(default_factory=Frozen)
    initial: Initial = field(default_factory=Initial)
    reference: Reference = field(default=cast("Reference", None))
    disturbance: Disturbance = field(default_factory=Disturbance)
    sensor: Sensor = field(default_factory=Sensor)
    actuator: Actuator = field(default_factory=Actuator)
    base: Base = field(default_factory=Base)
    effects: Mapping[str, Section] = field(default_factory=Frozen)
    guard: Guard = field(default_factory=Guard)
    filter: Filter = field(default_factory=Filter)
    changes: tuple[Change, ...] = ()
    clock: Clock = field(default_factory=Clock)
    metrics: Metrics = field(default_factory=Metrics)
    corridor: CorridorSettings = field(default_factory=CorridorSettings)
    ros: Ros = field(default_factory=Ros)
    world: World = field(default_factory=World)

    def __post_init__(self) -> None:
        """Freeze the contents and check the relations between the sections."""
        _check_types(self)
        object.__setattr__(self, "assumed", _assumed(self.assumed))
        object.__setattr__(self, "gains", clean_gains(self.gains))
        object.__setattr__(self, "changes", tuple(self.changes))
        object.__setattr__(self, "effects", Frozen(self.effects))
        if missing := missing_keys(self):
            raise MissingKeysError(missing_text(missing, sections()))
        for key, section in following(self):
            object.__setattr__(self, key, section)
        _relate(self)

    def __repr__(self) -> str:
        kind, clock = self.reference_kind.name, self.clock
        return f"<Scenario {self.name}; {kind}, {clock.duration:g} s at {clock.control:g} s>"

    def _repr_html_(self) -> str:
        """Every field with its value and unit, and the gains that laws run with, for notebooks."""
        parts = {key: self.table(key) for key in (*sections(), "reference")}
        parts |= {f"gains.{law}": gains for law, gains in self.gains_by_law().items()}
        rows = []
        for key, part in parts.items():
            for name, what in quantities(type(part)):
                value = field_outward(getattr(part, name), what.orientation, self.frames)
                text = "–" if value is None else str(value)
                if isinstance(value, Unstated):
                    text = "not stated" if isinstance(value, Unknown) else f"{text}, not stated"
                rows.append((f"{key}.{name}", text, what.unit, described(what.doc, self.frames)))
        return table_html(repr(self)[1:-1], rows, ("field", "value", "unit", "meaning"))

    def gains_by_law(self) -> Mapping[str, Section]:
        """The gains in effect, by law: the scenario's, and the law's defaults for unstated ones.

        ``kinematics`` has the gains of Eq. (7).  Raises ScenarioError or UnknownNameError if
        ``gains`` contains an unknown name.
        """
        return cast("Mapping[str, Section]", late_bound("gains_by_law")(self))

    @property
    def takes_velocity(self) -> bool:
        """True for a base that takes (v, omega), false for one that takes wheel torques."""
        return self.base.kind == "velocity"

    @property
    def believed(self) -> Robot:
        """The laws' model of the robot; no change ever alters it."""
        given = {key: value for key, value in vars(self.model).items() if value is not None}
        return dataclasses.replace(self.robot, **given)

    @property
    def split(self) -> float:
        """Time that splits the run into before and after, s."""
        return self.clock.duration / 2 if self.metrics.split is None else self.metrics.split

    @property
    def obstacles(self) -> tuple[Shape, ...]:
        """Shapes that the body must not touch: first the reference's, then the world's."""
        return (*self.reference.keep_out, *self.world.shapes)

    @property
    def reference_kind(self) -> ReferenceKind:
        """The kind of the reference: its graph and its numbers."""
        kind = REFERENCES.of(self.reference)
        assert kind is not None, "checked when the scenario was made"
        return kind

    @checks_arguments
    def table(self, key: str) -> Section:
        """The section of the table ``key``, with its defaults for keys that the scenario omits.

        ``model`` gives the complete robot that the laws assume.  Raises UnknownNameError.
        """
        if key == "model":
            return self.believed
        if key == "reference" or key in SECTIONS:
            part: Section = getattr(self, key)
            return part
        if key in self.effects:
            return self.effects[key]
        known = sections()
        if key not in known:
            raise UnknownNameError("section", key, known)
        return known[key]()

    @checks_arguments
    def section(self, cls: type[S]) -> S:
        """The section of class ``cls``, such as an effect's own.  Raises UnknownNameError."""
        part = self.table(cls.KEY)
        if not isinstance(part, cls):
            raise UnknownNameError("section", cls.__name__, sections())
        return part

    @checks_arguments
    def number(self, key: str) -> tuple[Signal, tuple[float, ...]]:
        """Signal and value of the number at a key path, or of a parameter of the reference.

        Raises UnknownNameError for a key that names no number.
        """
        section, _, name = key.partition(".")
        if not name:
            return self._of_reference(key)
        return number_of(self.table(section), name, key)

    @checks_arguments
    def value(self, key: str) -> tuple[float, ...]:
        """Value of the number at a key path."""
        section, _, name = key.partition(".")
        return numbers_in(self.table(section), name) if name else self._of_reference(key)[1]

    def _of_reference(self, name: str) -> tuple[Signal, tuple[float, ...]]:
        numbers = {item[0].name: item for item in self.reference_kind.numbers(self.reference)}
        if name not in numbers:
            raise UnknownNameError("number of the reference", name, numbers)
        return numbers[name]


OTHER_KEYS = ("title", "law", "frames", "assumed", "gains", "reference", "changes")
SECTIONS: dict[str, type[Section]] = {
    item.name: cast("type[Section]", kind)
    for item in dataclasses.fields(Scenario)
    if isinstance(kind := item.default_factory, type) and issubclass(kind, Section)
    if item.name not in OTHER_KEYS
}
"""Tables of a scenario that are one dataclass each and a field of Scenario, by key."""


def _check_types(scenario: Scenario) -> None:
    """Raise ScenarioError if a part of the scenario is not of its own class."""
    for name in ("name", "title"):
        if not isinstance(getattr(scenario, name), str):
            raise ScenarioError(f"{name} = {show(getattr(scenario, name))} must be text in quotes.")
    if scenario.law is not None and not isinstance(scenario.law, str):
        raise ScenarioError(f"law = {show(scenario.law)} must be a law's name in quotes.")
    checked_frames(scenario.frames)
    if scenario.reference is not None and REFERENCES.of(scenario.reference) is None:
        raise ScenarioError(f"reference must be one of the kinds {', '.join(REFERENCES)}.")
    if not isinstance(scenario.effects, Mapping):
        raise ScenarioError(f"effects = {show(scenario.effects)} must map tables to sections.")
    for key, part in scenario.effects.items():
        if type(part) is not EFFECTS.sections().get(key):
            raise ScenarioError(f"{key} = {show(part)} is not the section of an effect.")
    if as_list(scenario.changes) is None:
        raise ScenarioError(f"changes = {show(scenario.changes)} must be an array of changes.")
    for key, cls in SECTIONS.items():
        if type(part := getattr(scenario, key)) is not cls:
            raise ScenarioError(f"{key} = {show(part)} must be a {cls.__name__}.")


def _assumed(raw: object) -> tuple[str, ...]:
    """Assumed keys, each once; raises ScenarioError for an unknown key."""
    keys = as_list(raw)
    if keys is None:
        raise ScenarioError(f'assumed = {show(raw)} must be an array of keys, as in ["robot.m"].')
    known = {f"{table}.{name}" for table, cls in sections().items() for name, _ in quantities(cls)}
    known.add(KIND)
    for key in keys:
        if key not in known:
            raise ScenarioError(f"assumed: {show(key)} is no key such as robot.m.")
    return tuple(dict.fromkeys(map(str, keys)))


def _relate(scenario: Scenario) -> None:
    """Check changes against the run's end, and effects against the rest of the scenario."""
    _changes(scenario.changes, scenario.clock.duration)
    for key, other, most in multiples():
        (value,), (unit,) = scenario.value(key), scenario.value(other)
        check_multiple(key, value, other, unit, most)
    clock = scenario.clock
    for effect in EFFECTS:
        effect.relate(scenario)
    named = "reference.keep_out" if scenario.reference.keep_out else "world"
    if scenario.obstacles and scenario.body.radius is None:
        raise ScenarioError(
            f"{named} says what the body must not touch, but body.radius is not stated: the "
            "distance [m] from the axle's midpoint to the body's farthest point. State it."
        )
    low, high = scenario.guard.delay or (0.0, 0.0)
    if high - low > clock.control * (1 + ROUNDING):
        raise ScenarioError(
            f"guard.delay = [{low!r}, {high!r}] s may not vary by more than clock.control = "
            f"{clock.control!r} s: a command could take over after the next one. Narrow it, or "
            "lengthen clock.control."
        )
    split = scenario.metrics.split
    if split is not None and not split < clock.duration:
        raise ScenarioError(
            f"metrics.split = {split!r} s must be below clock.duration = {clock.duration!r} s: it "
            "splits the run in two. Leave it out to split at half the duration."
        )


def multiples() -> Iterator[tuple[str, str, int]]:
    """Keys of times, the time of which each must be a multiple, and the largest factor (0: any)."""
    for part in dict.fromkeys(effect.section.KEY for effect in EFFECTS):
        for name, what in quantities(sections()[part]):
            if what.multiple_of:
                yield f"{part}.{name}", what.multiple_of, what.most


def _changes(changes: tuple[Change, ...], duration: float) -> None:
    before = -1.0
    for i, change in enumerate(changes, start=1):
        if not isinstance(change, Change):
            raise ScenarioError(f"changes[{i}] must be a Change, or a table [[changes]] in TOML.")
        if change.m is None and change.I is None and change.mu is None:
            raise ScenarioError(f"changes[{i}] changes nothing: give it a new m, I or mu.")
        if change.t <= before:
            raise ScenarioError(
                f"changes[{i}].t = {change.t!r} s must be later than changes[{i - 1}].t = "
                f"{before!r} s: changes are listed in the order of time. Sort or merge them."
            )
        if change.t >= duration:
            raise ScenarioError(
                f"changes[{i}].t = {change.t!r} s must be before the run's end, clock.duration = "
                f"{duration!r} s. Make the run longer or remove the change."
            )
        before = change.t
