"""Numbers and sentences read as they are written in English."""

import pytest

from pipeline.report.wording import greek, per_cent, sentence, signed, true_minus


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("no route exists", "No route exists."),
        ("c3 needs 172.5 N.", "c3 needs 172.5 N."),
        ("route.kappa_max is 26", "route.kappa_max is 26."),
        ("", ""),
    ],
)
def test_sentences_begin_with_a_capital_unless_with_a_name(text: str, written: str) -> None:
    """Names of drives and keys keep their letters; every sentence ends with one full stop."""
    assert sentence(text) == written


def test_kappa_is_a_letter_but_not_in_keys() -> None:
    """In running text kappa is written as a letter; keys can still be copied."""
    assert greek("kappa integral 647; largest kappa") == "κ integral 647; largest κ"
    assert greek("refine.kappa_max") == "refine.kappa_max"


def test_minus_signs_are_true_ones() -> None:
    """Negative numbers have a minus sign, zero has none."""
    assert signed(-0.25, ".1f") == "−0.2"
    assert signed(-0.0, ".1f") == signed(-0.01, ".1f") == "0.0"
    assert true_minus("-144.9 to 110.7") == "−144.9 to 110.7"
    assert per_cent(-0.106, 1, "+") == "−10.6 %"
