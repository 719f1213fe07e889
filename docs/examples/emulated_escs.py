"""A driver's test without a motor: emulated C610s on python-can's virtual bus, and a driver that speaks to them."""

import can

from bench.config import load_robot
from bench.io.can_port import open_can
from bench.io.emulated.devices import EscsOnBus

escs = EscsOnBus(load_robot("m2006"), open_can("escs", "can:virtual:my-test"))
driver = can.Bus(interface="virtual", channel="my-test")

reports = []
for tick in range(200):  # each step is a millisecond; nothing here waits for a clock
    currents = bytes.fromhex("0258 0000 0000 0000")  # 600 mA on ESC 1
    driver.send(can.Message(arbitration_id=0x200, data=currents, is_extended_id=False))
    escs.step(tick)
    while (message := driver.recv(0)) is not None:
        if message.arbitration_id == 0x201:
            reports.append(int.from_bytes(message.data[2:4], "big", signed=True))

print(f"after 0.2 s the rotor of ESC 1 turns at {reports[-1]} rpm")
assert reports[-1] > 1000
driver.shutdown()
escs.close()
