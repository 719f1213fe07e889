"""What every test shares: one Hypothesis profile, the command, and where the recordings of other projects lie."""

import atexit
import os
import shutil
import socket
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# No deadline, and nothing is too slow: a busy machine is no bug. Derandomised, so that a red run is red again.
settings.register_profile("bench", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("bench")

# Nobody's own settings change a test, and no test changes them.
os.environ["XDG_CONFIG_HOME"] = tempfile.mkdtemp(prefix="wheelbench-tests-")
atexit.register(shutil.rmtree, os.environ["XDG_CONFIG_HOME"], ignore_errors=True)


@pytest.fixture(scope="session")
def captures() -> Path:
    """The folder that WHEELBENCH_CAPTURES names; recordings made by other projects are not part of this repository."""
    folder = os.environ.get("WHEELBENCH_CAPTURES")
    if not folder:
        pytest.skip(
            "WHEELBENCH_CAPTURES is not set: it names a folder of other people's captures, see fixtures/README.md"
        )
    return Path(folder)


@pytest.fixture
def multicast():
    """The address of a multicast bus of this test alone: tests that run at the same time would hear each other."""
    pytest.importorskip("msgpack", reason="msgpack is not installed: pip install 'wheelbench[multicast]'")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as held:  # so long nobody else is given its number
        held.bind(("", 0))
        for shared in (socket.SO_REUSEADDR, socket.SO_REUSEPORT):
            held.setsockopt(socket.SOL_SOCKET, shared, 1)
        yield f"can:udp_multicast:239.74.163.9?port={held.getsockname()[1]}"


@pytest.fixture
def call(capsys):
    """Run the command in this process: (exit status, stdout, stderr)."""
    from bench.__main__ import main

    def run(*arguments):
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as ended:
            status = ended.code
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return status, out, err

    return run
