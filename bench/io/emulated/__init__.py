"""Emulated hardware: what a driver or a firmware meets at the other end of its wire, in software.

    slcan       an SLCAN adapter on a serial line, with any bus behind it
    devices     ESCs with motors and plant on a CAN bus; a SLAMWARE base or core, and an RC receiver, on a serial line
    serve       runs devices in real time until somebody stops them

A device is stepped once a millisecond and never raises on what its wire brings. docs/emulate.md shows how to use them.
"""
