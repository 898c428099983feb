"""Two thousand mutated programs are interpreted without a traceback and without a hang."""

import importlib.util
from pathlib import Path

SCRIPT = Path(__file__).parents[1] / "benchmarks" / "fuzz_language.py"


def test_mutants_of_every_program_end_with_findings():
    spec = importlib.util.spec_from_file_location("fuzz_language", SCRIPT)
    fuzz_language = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fuzz_language)
    wrong, meanings = fuzz_language.fuzz(2000, 20260101)
    assert not wrong, wrong
    assert len(meanings) > 40
