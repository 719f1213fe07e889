"""The vendor's frames (fixtures/known/slamware), as the tests read them."""

import json
from pathlib import Path
from typing import Any

PATH = Path(__file__).parent.parent / "fixtures" / "known" / "slamware" / "vendor-frames.jsonl"

LINES: list[dict[str, Any]] = [json.loads(line) for line in PATH.read_text(encoding="utf-8").splitlines()]
BY_NAME = {line["name"]: line for line in LINES}


def frame(name: str) -> bytes:
    return bytes.fromhex(BY_NAME[name]["hex"])


def exchanges(run: str) -> list[tuple[str, bytes, bytes]]:
    """(name, request, all answers) of one boot of the reference base, in order."""
    found: dict[str, list[bytes]] = {}
    for line in LINES:
        if line.get("run") == run:
            parts = found.setdefault(line["exchange"], [b"", b""])
            parts[0 if line["seq"] == 0 else 1] += bytes.fromhex(line["hex"])
    return [(name, request, answers) for name, (request, answers) in found.items()]
