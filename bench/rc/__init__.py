"""Radio control: one file a protocol, the scaffold they share (`framing`), and captures on disk (`capture`).

The face is `bench.rc_decode`; nothing outside of this folder needs to know which file a protocol lives in.
"""
