"""`can:socketcand:` on the loopback: a server after socketcand's doc/protocol.md, python-can's client, or nobody."""

import gc
import socket
import threading
import time
from contextlib import contextmanager, suppress

import can.interfaces.socketcand  # noqa: F401  as nobody is to wait for the import
import pytest
from patience import DEADLINE_S, until

from bench.errors import SurroundingsError, UsageError
from bench.io.can_port import open_can
from bench.io.clock import wait_ns
from bench.io.kinds import bus_port, socketcand

PYTHON_CAN_S = 10.0
"""How long python-can goes on trying a host that refuses."""


class Server:
    """The modes NO_BUS and RAW of the protocol, for one client after the other. It says `greeting` first, ok to the
    `answers`, and to anything else `refusal`.
    """

    def __init__(self, number=0, greeting=b"< hi >", answers=(b"open can0", b"rawmode"), refusal=b""):
        self.greeting, self.answers, self.refusal = greeting, answers, refusal
        self.heard = []
        self.client = None
        self.listener = socket.create_server(("127.0.0.1", number))
        self.number = self.listener.getsockname()[1]
        self.serving = threading.Thread(target=self.serve)
        self.serving.start()

    def serve(self):
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            with client, suppress(OSError):  # who does not want to wait has left
                self.talk(client)

    def talk(self, client):
        self.client = client
        if self.greeting:
            client.sendall(self.greeting)
        said = b""
        while data := self.received(client):
            said += data
            while b">" in said:
                word, _, said = said.partition(b">")
                self.heard.append(word.strip(b"< "))
                answer = b"< ok >" if self.heard[-1] in self.answers else self.refusal
                if answer:
                    client.sendall(answer)

    @staticmethod
    def received(client):
        try:
            return client.recv(4096)
        except OSError:
            return b""

    def close(self):
        for end in (self.listener, self.client):
            if end is not None:
                with suppress(OSError):  # its other end may have left before
                    end.shutdown(socket.SHUT_RDWR)
        self.serving.join()
        self.listener.close()


@contextmanager
def server(**options):
    made = Server(**options)
    try:
        yield made
    finally:
        made.close()


def nobody():
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


def at(number):
    return f"can:socketcand:can0?host=127.0.0.1&port={number}"


def test_a_host_that_refuses_is_told_at_once():
    number, began = nobody(), time.monotonic()
    with pytest.raises(SurroundingsError) as told:
        open_can("--can", at(number))
    assert time.monotonic() - began < PYTHON_CAN_S / 2
    assert str(told.value) == (
        f"--can {at(number)}: no socketcand answers at 127.0.0.1:{number} (Connection refused); start it there"
    )


def test_a_host_that_says_nothing_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(bus_port, "CONNECT_S", 0.1)
    with server(greeting=b"") as silent, pytest.raises(SurroundingsError, match=r"\(timed out\); start it there"):
        open_can("--can", at(silent.number))


def openers():
    return [thread for thread in threading.enumerate() if thread.name == "socketcand"]


@pytest.fixture
def refused(monkeypatch):
    """What a server's refusal says. python-can leaves its socket to the garbage collector then; it comes here."""

    monkeypatch.setattr(bus_port, "CONNECT_S", DEADLINE_S)

    def said(**options):
        with server(**options) as refusing:
            address = at(refusing.number)
            with pytest.raises(SurroundingsError) as told:
                open_can("--can", address)
            text = str(told.value)
            until(lambda: b"open can0" in refusing.heard)
        assert text.startswith(f"--can {address}: socketcand at 127.0.0.1:{refusing.number} greets")
        return text

    yield said
    until(lambda: not openers())
    gc.collect()


LEFT_OPEN = pytest.mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")


@LEFT_OPEN
@pytest.mark.parametrize("answers", [(), (b"open can0",)])
def test_a_server_that_stalls_after_its_greeting_is_not_waited_for(monkeypatch, refused, answers):
    within = socketcand.Opening.within
    monkeypatch.setattr(socketcand.Opening, "within", lambda self, _, make: within(self, 0.05, make))
    text = refused(answers=answers)
    assert text.endswith("greets and then says nothing; restart it there, with can0 among its buses")


@LEFT_OPEN
def test_a_server_that_does_not_know_the_bus_is_told_what_it_said(refused):
    text = refused(answers=(), refusal=b"< error could not open bus >")
    assert "greets, but no more (Expected '< ok >' got: '< error could not open bus >')" in text


def test_a_stalled_opening_is_tried_once_and_taken_up_when_it_comes():
    """A thread that hangs cannot be ended: there is never a second one."""
    wait, asked = threading.Event(), []

    class Bus:
        shut = False

        def shutdown(self):
            self.shut = True

    def make():
        asked.append(Bus())
        wait.wait(DEADLINE_S)
        return asked[-1]

    opening = socketcand.Opening()
    for _ in range(3):
        with pytest.raises(TimeoutError):
            opening.within(0.001, make)
    until(lambda: asked)
    assert (len(asked), len(openers())) == (1, 1)
    wait.set()
    assert opening.within(DEADLINE_S, make) is asked[0]
    assert not asked[0].shut
    wait.clear()
    with pytest.raises(TimeoutError):
        opening.within(0.001, make)
    opening.give_up()
    wait.set()
    until(lambda: not openers())
    assert [bus.shut for bus in asked] == [False, True], "what nobody wants any more is closed"


def test_another_service_on_that_port_is_named(monkeypatch):
    monkeypatch.setattr(bus_port, "CONNECT_S", DEADLINE_S)  # it does say something, whenever it gets to it
    with server(greeting=b"SSH-2.0\r\n") as other, pytest.raises(SurroundingsError, match="is no socketcand"):
        open_can("--can", at(other.number))


@pytest.mark.parametrize("options", ["", "?host=127.0.0.1", "?port=29536", "?host=5&port=29536", "?host=here&port=no"])
def test_an_address_without_host_and_port_is_refused(options):
    with pytest.raises(UsageError, match="needs a host and a port"):
        open_can("--can", f"can:socketcand:can0{options}")


def test_frames_pass_and_a_server_that_went_is_found_again():
    got = []
    with server() as first:
        port = open_can("--can", at(first.number))
        port.write([(0x200, b"\x02\x58")])
        until(lambda: b"send 200 2 2 58" in first.heard)
        first.client.sendall(b"< frame 201 1.000000 BEEF >")
        until(lambda: got.extend(port.read()) or got)
        assert got == [(0x201, b"\xbe\xef")]
    until(lambda: (port.write([(0x200, b"")]), port.lost)[1])
    began = time.monotonic()
    assert not port.revive()
    wait_ns(500_000_000)
    assert not port.revive()
    assert time.monotonic() - began < PYTHON_CAN_S / 2, "a loop is not held up"
    assert "no socketcand answers" in port.lost
    with server(number=first.number) as again:
        until(port.revive)
        port.write([(0x200, b"\x01")])
        until(lambda: b"send 200 1 1" in again.heard)
        port.close()
    assert port.losses == 1
