"""The samples, in every form of report, say and do what they did when they were frozen."""

import json

import pytest
from frozen.transcripts import ROOT, name_of, rendered, then_and_now, transcripts


@pytest.mark.parametrize("path", transcripts("samples", "forms"), ids=name_of)
def test_sample_repeats_its_transcript(path):
    then, now = then_and_now(path)
    assert now == then


@pytest.mark.parametrize(
    ("group", "programs"), [("samples", "samples/*.nc"), ("golden", "tests/nc/golden/*.ngc")]
)
def test_every_program_has_a_transcript(group, programs):
    assert {path.stem for path in transcripts(group)} == {path.stem for path in ROOT.glob(programs)}


@pytest.mark.parametrize("path", transcripts(), ids=name_of)
def test_transcript_is_written_as_renewing_writes_it(path):
    text = path.read_text(encoding="utf-8")
    assert text == rendered(json.loads(text)) + "\n"
