"""CAN logs for the verbs that read them, in any format that python-can knows (candump .log, .asc, .blf, .trc ...)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from bench.canbus.measured import LoggedFrame
from bench.errors import UsageError


def frames(path: Path) -> Iterator[LoggedFrame]:
    """The classic data and remote frames of a log, in its order. Raises UsageError where it is none."""
    import can

    if not path.is_file():
        raise UsageError(f"{path}: is no file; give a CAN log such as candump's")
    try:
        # The readers raise what their parsers, zlib, struct and SQLite do; to the user that is one fault: no such log.
        with can.LogReader(path) as messages:
            for message in messages:
                if message.is_error_frame or message.is_fd:
                    continue
                yield LoggedFrame(
                    round(message.timestamp * 1e6),
                    message.arbitration_id,
                    bytes(message.data),
                    message.is_extended_id,
                    message.dlc if message.is_remote_frame else None,
                )
    except Exception as error:
        why = str(error) or type(error).__name__
        raise UsageError(f"{path}: is no CAN log that can be read ({why}); candump's .log is one") from None
