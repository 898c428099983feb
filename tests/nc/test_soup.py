"""Whatever the text, interpretation ends with findings and never with an exception."""

import io
import json

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gcodesim.nc.canon import write_canon
from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.control.supply import Control
from gcodesim.nc.iso.interpreter import interpret
from gcodesim.nc.iso.words import TABLE

CODES = st.sampled_from(sorted({row.name for row in TABLE if not row.refused}))
NUMBERS = st.one_of(st.integers(-20, 100).map(str), st.floats(-1e3, 1e3).map("{:.3f}".format))
BAD_NUMBERS = st.sampled_from(["", "-", ".", "1.2.3", "9" * 400, "-0", "1e5", "#1", "\0"])
LETTERS = st.sampled_from("XYZABCIJKRPQFSTHDNLEUO")


def words(letters, numbers, most):
    """Words with different letters, as one block."""
    pairs = st.lists(
        st.tuples(st.sampled_from(letters), numbers), max_size=most, unique_by=lambda p: p[0]
    )
    return pairs.map(lambda chosen: " ".join(map("".join, chosen)))


# Blocks that a post might write, so that programs live long enough to meet what comes later.
MOVES = st.builds(
    "{} {} F{}".format,
    st.sampled_from(
        ["", "G0", "G1", "G53 G0", "G91 G1", "G90 G1", "G28", "G92", "G52", "G20", "G21"]
    ),
    words("XYZABC", NUMBERS, 4),
    st.integers(1, 9999),
)
ARCS = st.builds(
    "{} {} {} F100".format,
    st.sampled_from(["G2", "G3", "G17 G2", "G18 G3", "G19 G2"]),
    words("XYZA", NUMBERS, 3),
    st.one_of(words("IJK", NUMBERS, 2), words("R", NUMBERS, 1)),
)
SETTINGS = st.one_of(
    CODES, st.builds("{} {}".format, CODES, CODES), words("TSF", st.integers(0, 99).map(str), 2)
)
SOUP = st.builds(
    "{} {}{}".format, st.one_of(st.just(""), CODES), LETTERS, st.one_of(NUMBERS, BAD_NUMBERS)
)
SIGNS = st.sampled_from(["(x)", "(MSG,hi)", "(", ")", ";", "/", "%", "[", " "])
BLOCKS = st.one_of(MOVES, MOVES, MOVES, ARCS, SETTINGS, SETTINGS, SOUP, SIGNS, st.text())
PROGRAMS = st.lists(BLOCKS, max_size=12).map("\n".join)


@settings(derandomize=True, max_examples=200, deadline=None, database=None)
@given(PROGRAMS, st.sampled_from(sorted(ROWS)))
def test_no_program_raises(text, dialect):
    meaning = interpret(text, Control(ROWS[dialect], feed=100.0), "soup.nc")
    assert np.isfinite(meaning.program.to).all()
    assert meaning.stopped == any(f.severity == "error" for f in meaning.findings)
    for finding in meaning.findings:
        assert finding.line is not None
        assert "\n" not in finding.message
    stream = io.StringIO()
    write_canon(meaning, stream)
    for line in stream.getvalue().splitlines():
        json.loads(line)


@settings(derandomize=True, max_examples=200, deadline=None, database=None)
@given(st.dictionaries(st.sampled_from("XYZABC"), st.floats(-1e6, 1e6), min_size=1))
def test_axis_words_come_out_as_they_went_in(given_words):
    block = "G0" + "".join(f"{letter}{value:.6f}" for letter, value in given_words.items())
    program = interpret(block + "\nM30", Control(ROWS["fanuc"])).program
    wanted = [float(f"{given_words.get(letter, 0.0):.6f}") for letter in "XYZABC"]
    reached = program.to[2] if program.kind[2] == 0 else program.start
    assert reached.tolist() == wanted
