"""YAML reading: YAML 1.2 scalars, and files made to hurt are refused."""

import pytest

from gcodesim.errors import ModelError, UsageError
from gcodesim.machine.yaml_lines import DEPTH_LIMIT, read_yaml


def read(tmp_path, text):
    path = tmp_path / "file.yaml"
    path.write_text(text)
    return read_yaml(path)


def test_scalars_and_lines(tmp_path):
    file = read(tmp_path, "a: 1e3\nb: [on, 1:30, 010,\n  ~, true, -5, .5]\nc: &c {d: 1}\ne: *c\n")
    assert file.data["a"] == 1000.0
    assert file.data["b"] == ["on", "1:30", 10.0, None, True, -5, 0.5]
    assert file.data["e"] == {"d": 1}
    assert file.line(("b", "3")) == 3
    assert file.line(("c", "d", "deeper")) == 4
    assert file.line(("nowhere",)) is None


ALIAS_BOMB = "\n".join(
    ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1]"]
    + [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 8)}]" for i in range(1, 9)]
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (ALIAS_BOMB, "more than 100000 values"),
        ("a: &a [*a]", f"nested deeper than {DEPTH_LIMIT}"),
        ("[" * 5000, "nested deeper"),
        ("a: !!python/object/apply:os.getcwd []", "unknown tag"),
        ("a: !!python/name:os.system x", "unknown tag"),
        ("a: !!bool perhaps", "no bool: 'perhaps'"),
        ('a: !!int ""', "no int: ''"),
        ("? !!set {b}\n: 1", "a key must be"),
        ("!!set b: 1", "unknown tag"),
        ("a: " + "[1, 2]," * 10**5, "no valid YAML"),
        ("a: [" + "1, " * 10**6, "more than 100000 values"),
        ("[1, 2]", "must be a mapping"),
        ("", "must be a mapping"),
        ("? [1]\n: 2", "plain word"),
        ("a: 1\n---\nb: 2", "no valid YAML"),
        ("a: \x01", "no valid YAML"),
    ],
)
def test_hostile_files(tmp_path, text, said):
    with pytest.raises(ModelError, match=said):
        read(tmp_path, text)


def test_unreadable(tmp_path):
    with pytest.raises(UsageError, match="cannot be read"):
        read_yaml(tmp_path / "missing.yaml")
    with pytest.raises(UsageError, match="5,000,003 bytes, and 4,194,304 are read"):
        read(tmp_path, "a: " + "x" * 5 * 10**6)
    (tmp_path / "latin.yaml").write_bytes(b"name: \xe4")
    with pytest.raises(ModelError, match="UTF-8"):
        read_yaml(tmp_path / "latin.yaml")
