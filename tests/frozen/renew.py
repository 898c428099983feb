"""Writes all transcripts again and names those that change: `python tests/frozen/renew.py`.

Words after it choose transcripts: `samples/` or `field/g01`.
"""

from __future__ import annotations

import json
import sys

from transcripts import name_of, rendered, repeated, transcripts


def renew(chosen: list[str]) -> None:
    """Write the transcripts whose names begin with one of the CHOSEN words, or all."""
    paths = [path for path in transcripts() if name_of(path).startswith(tuple(chosen or [""]))]
    changed = 0
    for path in paths:
        frozen = path.read_text(encoding="utf-8")
        now = rendered(repeated(json.loads(frozen))) + "\n"
        if now != frozen:
            changed += 1
            path.write_text(now, encoding="utf-8")
            print(name_of(path))
    print(f"{changed} of {len(paths)} transcripts changed")


if __name__ == "__main__":
    renew(sys.argv[1:])
