"""Products of facts that add up to 0, as `wmr_proofs.find` takes them."""

from fractions import Fraction

from wmr_proofs.check import Fact
from wmr_proofs.products import able_to_cancel, groups, multiples, product_of, shares

X, Y, Z = ((("|x|", 1),), (("|y|", 1),), (("|z|", 1),))
POSITIVE = {"x": Fact({X: 1}, ">"), "y": Fact({Y: 1}, ">")}


def added(facts, uses):
    """Nonzero factors with which products add up to 0; None if no factors do."""
    found = {used: product_of(facts, used, {}) for used in uses}
    free = multiples(facts, found, 1)
    found = able_to_cancel(found, free)
    above = {used: strict for used, (_, strict) in found.items()}
    value = shares({used: p for used, (p, _) in found.items()} | free, above)
    return value and {used: share for used, share in value.items() if share}


def test_facts_are_multiplied_by_unknowns_of_known_sign():
    """z >= 2 x y and x x y > x z contradict each other if x and y are above 0."""
    xy, xxy = X + Y, (("|x|", 2), ("|y|", 1))
    facts = POSITIVE | {"a": Fact({Z: 1, xy: -2}, ">="), "b": Fact({xxy: 1, X + Z: -1}, ">")}

    sums = [value for group in groups(facts, "ab") if (value := added(facts, group))]
    (first, *_) = sums

    assert first.keys() >= {("x", "a")}
    total = {}
    for used, share in first.items():
        p, _ = product_of(facts, used, {})
        assert share > 0
        for monomial, c in p.items():
            total[monomial] = total.get(monomial, 0) + share * c
    assert not any(total.values())


def test_products_of_another_unit_are_in_another_group():
    """x + z >= 0 gives x and z the same unit, and nothing gives y one."""
    facts = POSITIVE | {"sum": Fact({X: 1, Z: 1}, ">=")}
    group = next(group for group in groups(facts, ["sum"]))

    assert all("sum" in used or "x" in used for used in group)
    assert len({used.count("y") for used in group}) == 1


def test_many_polynomials_are_added_up_exactly():
    """1/3 of a fact and 2/7 of another, among others that do not help."""
    facts = {
        "a": Fact({X: Fraction(3), Y: Fraction(-1, 3)}, ">="),
        "b": Fact({X: Fraction(-7, 2), Y: Fraction(7, 18)}, ">="),
        "one": Fact({(): 1}, ">"),
        "less": Fact({(): -1, X: 1, Y: Fraction(-1, 9)}, ">="),
        "more": Fact({X: -1, Y: Fraction(1, 9)}, ">="),
    }
    several = facts | {f"other {k}": Fact({X: k, Y: 1, Z: k * k - 7}, ">=") for k in range(20)}
    for chosen in (facts, several):
        value = added(chosen, [(name,) for name in chosen])

        total = {}
        for (name,), share in value.items():
            for monomial, c in chosen[name].poly.items():
                total[monomial] = total.get(monomial, 0) + share * c
        assert not any(total.values())
        assert value["one",] > 0


def test_no_sum_is_found_where_facts_can_hold_together():
    facts = POSITIVE | {f"larger {k}": Fact({X: k, Y: -1}, ">=") for k in range(1, 20)}

    assert added(facts, [(name,) for name in facts]) is None
