"""Programs of the field, and small ones that once were wrong, say and do what they did."""

import pytest
from frozen.transcripts import name_of, then_and_now, transcripts

CASES = transcripts("field", "programs", "geometry", "breakage")


@pytest.mark.parametrize("path", CASES, ids=name_of)
def test_case_repeats_its_transcript(path):
    then, now = then_and_now(path)
    assert now == then
