"""Setup: a law on a scenario with all gains, guard numbers, limits and effects, checked.

Everything that builds or judges a run receives this value; no other code derives gains.  Numbers
keep their scenario keys, so a graph's parameters can be filled without the graph.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import TypeVar

from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.core.fields.section import Section, build, number_of, numbers_in
from wmr_ctrl.core.signals import COMMAND, TORQUE, Signal
from wmr_ctrl.results import Assumptions
from wmr_ctrl.world.effect import Bound, Effect, EffectRole, total
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.model.kinematics import KinematicGains
from wmr_ctrl.world.references.kind import check_finite
from wmr_ctrl.world.references.registry import OURS as OUR_REFERENCES
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario, override, preset_names

from .basis import ANY_BASIS, basis_of
from .filter.filter import derived_numbers
from .filter.hypotheses import check_velocity_base
from .guard.bounds import GuardNumbers, assumptions, derived_guard
from .guard.contradictions import (
    Contradiction,
    beyond_belief,
    contradictions,
    refuse_contradictions,
)
from .guard.price import speed_price
from .guard.refusals import feasible_guard
from .laws.given import law_name
from .laws.law import (
    Basis,
    Law,
    OwnKinematics,
    Predicting,
    TorqueLimited,
    commands_predicted,
)
from .laws.registry import LAWS, blamed_law

KINEMATICS = "kinematics"
OF_FILE = "The gains of a law in a file are known where it is named, as in --law my_law.py."
GUARD_ALONE = "guard"
"""Name of a setup without a law."""
S = TypeVar("S", bound=Section)
_FINITE: dict[tuple[object, ...], None] = {}


@dataclass(frozen=True)
class Setup:
    """A law (or the guard alone) on a scenario, with every number that follows from them.

    ``gains`` are the law's, ``kinematics`` those of Eq. (7), ``guard`` the numbers of the guard:
    feasible if it is on, as stated or implied if it is off.  ``effects`` are those present.
    """

    scenario: Scenario
    law: Law | None
    gains: Section
    kinematics: KinematicGains
    guard: GuardNumbers
    effects: tuple[Effect, ...]

    @property
    def name(self) -> str:
        """Name of the law; "guard" for the guard alone."""
        return self.law.name if self.law else GUARD_ALONE

    @property
    def control_law(self) -> Law:
        """The law of a setup that must have one."""
        if self.law is None:
            raise ArgumentError(
                "no law is named, and the guard by itself drives nothing. Name one: "
                f"{', '.join(LAWS)}."
            )
        return self.law

    @property
    def takes_velocity(self) -> bool:
        """True if the base takes velocities."""
        return self.scenario.takes_velocity

    @property
    def commanded(self) -> tuple[Signal, ...]:
        """Signals that the controller sends: wheel torques, or velocities."""
        return COMMAND if self.takes_velocity else TORQUE

    @property
    def tau_max(self) -> float:
        """Torque limit of each wheel [N m]: the drives', or the law's own if it is smaller."""
        return wheel_limit_of(self.scenario, self.gains)

    @property
    def kinematic_key(self) -> str:
        """Key of the law's k of Eq. (7): its own, or the one that laws share."""
        own = isinstance(self.gains, OwnKinematics) and self.gains.kinematics is not None
        return f"gains.{self.name}.{KINEMATICS}" if own else f"gains.{KINEMATICS}.k"

    @property
    def prediction(self) -> float:
        """The delay over which the law predicts [s]."""
        return self.gains.delay if isinstance(self.gains, Predicting) else 0.0

    @property
    def predicted(self) -> int:
        """Number of commands in transit over which the law predicts."""
        return commands_predicted(self.gains, self.scenario.clock.control)

    @property
    def assumptions(self) -> Assumptions:
        """A guard's assumptions on the motion, whether it is on or off."""
        assumed = replace(assumptions(self.scenario, self.guard), void=self.void)
        if not self.scenario.guard.enabled:
            return assumed
        price = speed_price(self.scenario, self.guard)
        return replace(assumed, usable=price.usable, asked=price.asked)

    @property
    def void(self) -> str:
        """Sentences on the guarantee's assumptions that the scenario itself violates; or empty.

        These are effects that no bound covers, a robot that differs from the believed one, and
        stated bounds that are violated and permitted by guard.trust.
        """
        return " ".join(filter(None, (self.bound.void, *(item.sentence for item in self.broken))))

    @cached_property
    def broken(self) -> tuple[Contradiction, ...]:
        """Numbers of an active guard that the scenario violates and guard.trust permits."""
        if not self.scenario.guard.enabled:
            return ()
        stated = contradictions(self.scenario, self.bound)
        return *stated, *beyond_belief(self.scenario, self.guard, self.bound)

    @cached_property
    def bound(self) -> Bound:
        """Sum of all effects' bounds, for the guard's assumptions."""
        return bound_of(self.scenario, self.effects)

    def own(self, cls: type[S]) -> S:
        """The law's gains, checked to be of class ``cls``; raises ArgumentError for another
        law's.
        """
        if not isinstance(self.gains, cls):
            raise ArgumentError(f"{self.name} has {type(self.gains).__name__}, not {cls.__name__}.")
        return self.gains

    def with_role(self, role: EffectRole) -> tuple[Effect, ...]:
        """Present effects of one role, in the order in which they are composed."""
        return tuple(item for item in self.effects if item.role is role)

    def number(self, key: str) -> tuple[Signal, tuple[float, ...]]:
        """Signal and value of the number at a key: the law's gains, the guard's, the scenario's.

        Raises KeyError for a key that names no number.
        """
        if key in self._of_filter:
            return self._of_filter[key]
        section, name = self._place(key)
        return number_of(section, name, key) if section else self.scenario.number(key)

    def value(self, key: str) -> tuple[float, ...]:
        """Value of the number at a key."""
        if key in self._of_filter:
            return self._of_filter[key][1]
        section, name = self._place(key)
        return numbers_in(section, name) if section else self.scenario.value(key)

    @cached_property
    def _of_filter(self) -> dict[str, tuple[Signal, tuple[float, ...]]]:
        return derived_numbers(self.scenario)

    def _place(self, key: str) -> tuple[Section | None, str]:
        """Section and field of a key; no section if it belongs to the scenario."""
        table, _, name = key.partition(".")
        if table == "guard":
            return self.guard, name
        if table != "gains":
            return None, name
        law, _, gain = name.partition(".")
        if law not in (KINEMATICS, self.name):
            raise KeyError(key)
        return self.kinematics if law == KINEMATICS else self.gains, gain


def settle(scenario: Scenario, law: str | None) -> Setup:
    """The Setup of ``law`` on ``scenario``, for the guard alone if ``law`` is None.

    Raises UnknownNameError for a law, effect or gain that does not exist, ScenarioError for a bad
    value, a reference that is not finite, or a guard that is on and cannot keep its limits or
    assumes bounds that the scenario violates.
    """
    chosen = None if law is None else LAWS[law]
    if scenario.filter.kind != "none" and not scenario.takes_velocity:
        raise ScenarioError(
            f'filter.kind = "{scenario.filter.kind}": the command filter is for bases that take '
            "velocities, and this robot takes torques, which the guard limits. Set base.kind = "
            '"velocity", or filter.kind = "none"; for the filter by itself take '
            "wmr_ctrl.command_filter or `wmr-ctrl codegen filter`."
        )
    return _settled(with_kinematics(with_traction_limit(scenario), chosen), chosen, tuple(EFFECTS))


@lru_cache(maxsize=4096)
def _settled(scenario: Scenario, chosen: Law | None, known: tuple[Effect, ...]) -> Setup:
    """Uncached `settle` for this law and these effects, which other packages may change."""
    named = check_gains(scenario)
    _finite_reference(scenario)
    gains = Section() if chosen is None else named.get(chosen.name) or gains_of(scenario, chosen)
    present = tuple(item for item in known if item.present(scenario))
    settling = scenario.guard.enabled or chosen is None
    boundless = [item.title for item in present if item.bound is None]
    if settling and boundless:
        raise ScenarioError(
            f"guard.enabled: the effect {boundless[0]} states no bound, "
            "so the guard has nothing to rely on. Switch the guard off, remove the effect from "
            "the scenario, or give its Effect a bound."
        )
    bound, limit = bound_of(scenario, present), wheel_limit_of(scenario, gains)
    guard = (
        feasible_guard(scenario, bound, limit, partial(bound_of, present=present))
        if settling
        else derived_guard(scenario, bound, limit)
    )
    if scenario.guard.enabled:
        refuse_contradictions(scenario, bound)
    if scenario.takes_velocity:
        check_velocity_base(scenario, gains, bound)
    return Setup(scenario, chosen, gains, kinematic_gains(scenario), guard, present)


def check_name(scenario: str) -> None:
    """Raise ArgumentError if a law's name is given in place of a scenario's."""
    if scenario in LAWS and scenario not in preset_names():
        raise ArgumentError(
            f"{scenario!r} is a law, but the first argument is the scenario: "
            f'`wmr-ctrl run far-start --law {scenario}`, or simulate("far-start", "{scenario}").'
        )


def check_scenario(scenario: Scenario) -> None:
    """Raise the errors of `settle` common to all laws: invalid gains, reference or guard.

    An active guard is checked without any law's own torque limit; UnknownNameError for its law.
    """
    if scenario.law is not None:
        _ = LAWS[law_name(scenario.law)]
    check_gains(scenario)
    _finite_reference(scenario)
    if scenario.guard.enabled:
        settle(scenario, None)


def gains_of(scenario: Scenario, law: Law) -> Section:
    """The law's gains: stated by the scenario, else from the law's rule, else the law's defaults.

    Raises on unknown names and bad values.
    """
    stated = scenario.gains.get(law.name, {})
    with blamed_law(law, law.gains.relate):
        followed = _followed(law.rule, scenario, stated)
        return build(law.gains, {**followed, **stated}, f"gains.{law.name}")


def _followed(
    rule: Callable[[Basis], Mapping[str, object]], scenario: Scenario, stated: Mapping[str, object]
) -> Mapping[str, object]:
    """Gains by a rule; empty if the scenario states all of them."""
    if rule(ANY_BASIS).keys() <= stated.keys():
        return {}
    return rule(basis_of(scenario))


def gains_by_law(scenario: Scenario) -> dict[str, Section]:
    """Gains of every law: the scenario's, else the law's own; those of Eq. (7) first."""
    laws = {name: gains_of(scenario, LAWS[name]) for name in LAWS}
    return {KINEMATICS: kinematic_gains(scenario)} | laws


def following_gains(law: str) -> frozenset[str]:
    """Names of the gains that are derived from robot, base and path unless stated."""
    return frozenset({"k"} if law == KINEMATICS else LAWS[law].rule(ANY_BASIS))


def kinematic_gains(scenario: Scenario) -> KinematicGains:
    """k_1, k_2, k_3 of Eq. (7)."""
    stated = scenario.gains.get(KINEMATICS, {})
    followed = _followed(lambda basis: {"k": basis.k}, scenario, stated)
    return build(KinematicGains, {**followed, **stated}, f"gains.{KINEMATICS}")


def with_kinematics(scenario: Scenario, law: Law | None) -> Scenario:
    """The scenario with the law's own gains of Eq. (7), if any, in place of the shared ones."""
    gains = None if law is None else gains_of(scenario, law)
    if not isinstance(gains, OwnKinematics) or gains.kinematics is None:
        return scenario
    return override(scenario, {f"gains.{KINEMATICS}.k": list(gains.kinematics)})


def check_gains(scenario: Scenario) -> dict[str, Section]:
    """Gains of the laws that the scenario names, by law.

    Raises UnknownNameError for a law or a gain that does not exist, ScenarioError for a bad value.
    """
    kinematic_gains(scenario)
    laws = [name for name in scenario.gains if name != KINEMATICS]
    for name in laws:
        if name not in LAWS:
            raise UnknownNameError("section of gains", name, (*LAWS, KINEMATICS), OF_FILE)
    return {name: gains_of(scenario, LAWS[name]) for name in laws}


def wheel_limit_of(scenario: Scenario, gains: Section) -> float:
    """The smaller of actuator.tau_max and the law's own limit, if any [N m]."""
    limit = scenario.actuator.tau_max
    return min(limit, gains.tau_max) if isinstance(gains, TorqueLimited) else limit


def bound_of(scenario: Scenario, present: tuple[Effect, ...]) -> Bound:
    """Sum of the effects' bounds, the guard's assumptions; effects without a bound add nothing."""
    return total([b for item in present if (b := item.bounded(scenario)) is not None])


def with_traction_limit(scenario: Scenario) -> Scenario:
    """The scenario with wheel torques limited to what its tyres can surely transmit, if requested.

    With actuator.traction, tau_max is at most `Grip.keep` of the true robot in each of its phases.
    This is a limit of the vehicle, like that of its motors.  Raises ScenarioError if it is 0.
    """
    if not scenario.actuator.traction:
        return scenario
    most = grip(scenario).keep
    if most <= 0:
        raise ScenarioError(
            "actuator.traction limits torques to what the tyres of [body] can transmit, and in "
            "the tightest turn at limits.v_u1 that is nothing. Lower limits.v_u1, or state better "
            "tyres (body.tyre) or less friction."
        )
    return override(scenario, {"actuator.tau_max": min(most, scenario.actuator.tau_max)})


def one_period_later(setup: Setup) -> Setup:
    """The setup with drives that are one control period later.

    A controller that is built for it suits a master that passes values on only after all parts have
    stepped.  Raises ScenarioError, which states both delays.
    """
    stated, period = setup.scenario.actuator.delay, setup.scenario.clock.control
    try:
        return settle(override(setup.scenario, {"actuator.delay": stated + period}), setup.name)
    except ScenarioError as error:
        raise ScenarioError(
            f"{error} Here actuator.delay counts {stated:g} s of the scenario and one control "
            f"period, {period:g} s, by which the master delays torques: where no smaller one is "
            "possible, step in order (gauss-seidel)."
        ) from error


def _finite_reference(scenario: Scenario) -> None:
    """Check that a reference is finite, once for all scenarios that share it."""
    kind = scenario.reference_kind
    key = (kind, scenario.reference, scenario.clock if kind in OUR_REFERENCES else scenario)
    if key not in _FINITE:
        check_finite(scenario)
        if len(_FINITE) > 4096:
            _FINITE.clear()
        _FINITE[key] = None
