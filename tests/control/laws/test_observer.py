"""The observer of the force that the model does not explain."""

from tests.control.laws.points import assert_twin
from tests.papers_robot import paper
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.observer import Observer
from wmr_ctrl.control.setup import settle


def test_it_counts_on_friction_at_the_mean_velocity_and_begins_with_nothing():
    assert_twin("prox")


def test_it_publishes_the_negative_of_its_force():
    context = LawContext(settle(paper(), "mb"))
    observer = Observer(context, context.period, context.friction_at)

    assert (observer.diagnostics[0].expr + observer.force).is_zero()
    assert len(observer.state) == 3
