"""The golden programs of every language say and do what they did when they were frozen."""

import pytest
from frozen.transcripts import name_of, then_and_now, transcripts

GOLDEN = transcripts("golden", "compensation", "siemens", "heidenhain")


@pytest.mark.parametrize("path", GOLDEN, ids=name_of)
def test_golden_program_repeats_its_transcript(path):
    then, now = then_and_now(path)
    assert now == then
