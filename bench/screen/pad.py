"""The mouse's sticks as a panel: a pad for forward and left, a strip for the turn, and what a stick's way becomes."""

from __future__ import annotations

from bench.screen.mouse_sticks import Box, pad_of
from bench.screen.scene import Scene
from bench.screen.text import KEY, LABEL, PLAIN, Line

KNOB = "◉"


def pad(scene: Scene, width: int, height: int) -> list[Line]:
    """Both sticks with their knobs, and beside them how they are set."""
    hands = scene.hands
    assert hands is not None
    forward, left, turn = hands.pad or (0.0, 0.0, 0.0)
    power = hands.power_percent / 100.0
    shape = pad_of(width, height)
    rows = [[" "] * width for _ in range(height)]
    _box(rows, shape.stick, " forward, left ", (-left / power, -forward / power))
    _box(rows, shape.turn, " turn ", (-turn / power, 0.0))
    column = shape.turn.x
    far = f"full way {hands.power_percent} %"
    notes = {shape.turn.y - 3: f"{far}, {hands.curve}"}
    if column + len(notes[shape.turn.y - 3]) > width:
        notes = {shape.turn.y - 3: far, shape.turn.y - 2: hands.curve}
    notes[shape.turn.y + 3] = "let go: at rest   M: mouse back"
    lines: list[Line] = []
    for y, row in enumerate(rows):
        before, knob, behind = "".join(row[:column] if y in notes else row).partition(KNOB)
        lines.append([(before, LABEL), (knob, KEY), (behind, LABEL), (notes.get(y, ""), PLAIN)])
    return lines


def _box(rows: list[list[str]], box: Box, title: str, knob: tuple[float, float]) -> None:
    left, top, right, bottom = box.x - 1, box.y - 1, box.x + box.width, box.y + box.height
    for y in range(box.y, bottom):
        _put(rows, y, left, "│" + " " * box.width + "│")
    _put(rows, top, left, "┌" + title.center(box.width, "─") + "┐")
    _put(rows, bottom, left, "└" + "─" * box.width + "┘")
    middle_x, middle_y = box.x + box.width // 2, box.y + box.height // 2
    _put(rows, middle_y, box.x, "·" * box.width)
    for y in range(box.y, bottom):
        _put(rows, y, middle_x, "·")
    x, y = (round(max(-1.0, min(1.0, share)) * (cells // 2)) for share, cells in zip(knob, box[2:], strict=True))
    _put(rows, middle_y + y, middle_x + x, KNOB)
    assert right < len(rows[0]), "the panel is too narrow for its sticks"


def _put(rows: list[list[str]], y: int, x: int, text: str) -> None:
    if 0 <= y < len(rows):
        rows[y][x : x + len(text)] = text
