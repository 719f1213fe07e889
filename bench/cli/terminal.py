"""Is there a terminal to show a dashboard in?"""

from __future__ import annotations

import os
import sys


def has_terminal() -> bool:
    """Whether keys can come in and a picture can go out. The dashboard draws on stderr, so that counts too."""
    return os.environ.get("TERM") != "dumb" and all(
        stream is not None and stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)
    )
