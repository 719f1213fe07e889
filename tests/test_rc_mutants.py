"""What a change in an RC decoder would break and no other test sees: each of these has killed a mutant."""

import streams

from bench import rc_decode
from bench.messages import RcFrame, RcNoise
from bench.rc import sbus


def test_an_sbus_frame_is_believed_before_one_that_lost_its_header_however_reads_cut_it():
    first, headless, last = (sbus.encode((raw,) * 16) for raw in (1000, 1010, 1020))
    expected = [
        RcFrame(0, 25, (1000,) * 16),
        RcNoise(25, 24, "header"),
        RcFrame(49, 25, (1020,) * 16),
    ]
    streams.check_stream(lambda: rc_decode.decoder("sbus"), first + headless[1:] + last, expected)
