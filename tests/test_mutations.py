"""The deliberate errors of `mutations.toml` fit the tree as it is; `mutations.py` tries them."""

from tests.mutations import MUTATIONS, ROOT


def test_each_error_is_of_a_text_that_stands_once_in_its_file() -> None:
    assert [fault for it in MUTATIONS if (fault := it.fault())] == []


def test_each_error_has_a_meaning_of_its_own() -> None:
    assert len({it.meaning for it in MUTATIONS}) == len(MUTATIONS)


def test_each_error_names_a_test_that_is_there() -> None:
    unknown = []
    for it in MUTATIONS:
        file, _, name = it.test.partition("::")
        function = f"def {name.partition('[')[0].rpartition('::')[2]}("
        if name and function not in (ROOT / file).read_text():
            unknown.append(it.test)
    assert unknown == []
