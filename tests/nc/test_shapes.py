"""Texts that differ in their numbers only are read once, and mean what each means by itself."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nc.controls import make_control
from nc.test_runs import assert_equal

from gcodesim.nc.interpret import interpret
from gcodesim.nc.iso import statements

NUMBERS = st.sampled_from(
    [
        "0",
        "1",
        "2",
        "3.",
        ".5",
        "12.345",
        "007",
        "100",
        "101",
        "9999",
        "1000000000000",
        "1.2.3",
        ".",
    ]
)
SHAPES = st.sampled_from(
    ["G1 X[#{}+{}] Y-{} F{}", "#{}={}", "#{}=[{}*2]/#{}", "G0 X#{} Z-[{}/#{}]", "X-{} Y+{} (c{})"]
    + ["#{}=SQRT[{}-#{}]", "#{}=#[{}+{}]", "IF[#{}LT{}]GOTO{}", "IF[#{}EQ#0]THEN#{}={}", "N{} X#{}"]
    + ["#<a{}>={}", "G{} X[#<a{}>+{}]", "WHILE[#{}LT{}]DO{}", "END{}", "O{}", "O{} IF [#{} GT {}]"]
    + [
        "O{} ENDIF",
        "G4 P[{}]",
        "X[{}",
        "X{}#{}",
        "#{}={} #{}=ATAN[{}]/[{}]",
        "S{} M3 X#{}",
        "/#{}={}",
    ]
    + ["#{}=-{}**{}", "X[1GT{}] H[#{}]", "G1X#{}G{}", "X[#{}*COS[{}]+SIN[{}]-{}]", "G65 P{} A#{}"]
)
LINES = st.builds(
    lambda shape, numbers: shape.format(*numbers), SHAPES, st.lists(NUMBERS, min_size=5, max_size=5)
)
TAME = st.sampled_from(
    ["#1=2", "#2=.5", "#3=#1", "X[#1+2.25]", "X[#2+10]", "Y[#3-#1]", "X#4", "X[1/#1]", "X[1/#20]"]
)


@settings(derandomize=True, max_examples=600, deadline=None, database=None)
@given(
    st.lists(TAME, max_size=12), st.lists(LINES, max_size=4), st.sampled_from(["fanuc", "linuxcnc"])
)
def test_a_shared_shape_means_what_the_text_means_by_itself(tame, lines, dialect):
    text = "\n".join(["G1 F100 S5 M3", *tame, *lines, "X[#1 + 5]", "M30"])
    shared = interpret(text, make_control(dialect), "p.nc")

    def alone(self, text):
        return statements.parse(text, self.rules), (), ()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statements.Shapes, "read", alone)
        assert_equal(shared, interpret(text, make_control(dialect), "p.nc"))


def test_a_finding_stands_where_its_own_text_has_it():
    text = "G0 X1\n#1=1\n#20=0\nX[1/#1] Y2\nX[1000.125/#20] Y2\nM30"
    (finding,) = interpret(text, make_control(), "p.nc").findings
    assert (finding.line, finding.column, finding.meaning) == (5, 11, "division_by_zero")


def test_a_word_is_refused_where_its_own_text_has_it():
    text = "#1=1\nG1 X[#1+1] F5 S5 M3\nG1 X[#1+1.2345] F-5 S5 M3\nM30"
    (finding,) = interpret(text, make_control(), "p.nc").findings
    assert (finding.line, finding.column, finding.meaning) == (3, 17, "feed_negative")
