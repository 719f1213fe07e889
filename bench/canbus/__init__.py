"""The motors' CAN bus around `m2006`: what its messages are, how long they take on the wire, whether they all fit.

`table` describes messages; `c610` and `dm3519` are the tables; `dbc` exports them. `bits` counts the bits of any
classic frame, `budget` what a bus of such frames can carry, `watch` says who is on the bus that should not be. Nothing
here moves a frame: both ends of the wire are in `bench.m2006` and `bench.dm3519`.
"""
