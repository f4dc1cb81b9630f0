"""Plain data: what goes in comes out, and nothing else does."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from pgm_book.course.boxed import plain

numbers = st.none() | st.booleans() | st.integers() | st.floats() | st.complex_numbers()
leaves = numbers | st.text() | st.just(...)
kinds = arrays.scalar_dtypes() | arrays.unicode_string_dtypes()
some_arrays = arrays.arrays(
    kinds.filter(lambda d: d.kind in "biufcU"), arrays.array_shapes()
)
values = st.recursive(
    leaves | some_arrays,
    lambda inner: (
        st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(st.text(), inner)
    ),
    max_leaves=8,
)


def travelled(value):
    return plain.unpacked(json.loads(json.dumps(plain.packed(value))))


@given(values)
def test_values_come_back_as_they_were(value):
    found = travelled(value)
    assert type(found) is type(value)
    np.testing.assert_equal(found, value)
    if isinstance(value, np.ndarray):
        assert found.dtype == value.dtype and found.flags.writeable


@pytest.mark.parametrize("value", [object(), {1, 2}, print, np.array([None]), int])
def test_what_is_no_plain_data_is_refused_before_it_travels(value):
    with pytest.raises(TypeError, match="no plain data"):
        plain.packed([value])


@pytest.mark.parametrize(
    "said",
    [
        {"array": ["|O", [1], "AAAAAAAAAAA="]},  # objects would be pointers
        {"array": ["<f8", [2], "AAAAAAAAAAA="]},
        {"array": ["<f8", [-1], "AAAAAAAAAAA="]},
        {"array": ["<f8", [10**9, 10**9], ""]},
        {"array": ["__import__('os')", [1], "AA=="]},
        {"array": 7},
        {"function": 3},
        {"dict": [[[], 1]]},
        {"fields": {"dict": [[1, 2]]}},
        {"fields": {"dict": [["__array_interface__", {"dict": []}]]}},  # a pointer
        {"eval": "1"},
        {"int": "1", "float": "2"},
        {},
    ],
)
def test_a_strangers_description_of_no_value_is_refused(said):
    with pytest.raises(ValueError, match="no plain data"):
        plain.unpacked([said])
