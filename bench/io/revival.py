"""What may be lost and come back: a cable, an adapter, a pad. Lost, it is tried again, at most every half second."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from bench.io.clock import now_ns

RETRY_NS = 500_000_000


class Revivable(ABC):
    """Each kind says how it is opened (`_open`), let go (`_release`), and what opening may raise (`_refusals`)."""

    _refusals: ClassVar[tuple[type[Exception], ...]] = (OSError,)

    def __init__(self, lost: str = "") -> None:
        self.lost = lost
        """Why it cannot be used now; empty while it can."""
        self.losses = 0
        """How often it was lost."""
        self._retry_ns = 0

    def revive(self) -> bool:
        """Try to open it again if it is lost and the time has come; whether it is open now."""
        if not self.lost:
            return True
        if now_ns() < self._retry_ns:
            return False
        self._retry_ns = now_ns() + RETRY_NS
        try:
            self._open()
        except self._refusals as error:
            self.lost = self._why(error)
            return False
        self.lost = ""
        return True

    def _lose(self, why: str) -> None:
        """It has gone: let go of it until `revive` finds it again."""
        self._release()
        self.lost = why
        self.losses += 1
        self._retry_ns = now_ns() + RETRY_NS

    @staticmethod
    def _why(error: Exception) -> str:
        """What was raised, for people."""
        return getattr(error, "strerror", None) or str(error) or type(error).__name__

    @abstractmethod
    def _open(self) -> None:
        """Open it. Raises one of `_refusals`."""

    @abstractmethod
    def _release(self) -> None:
        """Let go of whatever is open; nothing may be."""
