"""The shape of the house, as imports: what may know of what."""

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[1] / "bench"
MODULES = {path.relative_to(BENCH).as_posix(): ast.parse(path.read_text()) for path in BENCH.rglob("*.py")}

# Who alone may import what, anywhere in the file.
ONLY_IN = {
    "evdev": ("io/gamepad.py",),
    "textual": ("tui.py", "screen/"),
    "rich": ("tui.py", "screen/"),
    "pymunk": ("hull.py",),
    "serial": ("io/ports.py", "io/kinds/serial_device.py", "io/surroundings.py"),
    "can": ("io/ports.py", "io/kinds/bus_port.py", "io/timed_can.py", "cli/canlog.py"),
    "time": ("io/clock.py",),
    "datetime": (),
    "random": ("check/faulty/",),  # a seeded generator for each fault
    # Which thread may catch signals; a bus whose nodes may be in any thread of somebody else's program; and a library's
    # call that may never come back.
    "threading": ("cli/headless.py", "io/timed_can.py", "io/kinds/socketcand.py"),
    "signal": ("cli/headless.py", "tui.py", "io/forked.py", "check/crowd.py"),
    "_signal": ("cli/interrupt.py",),  # before there has been time to read `signal`
    "asyncio": ("screen/web.py",),  # whose turn it is, among pages; nothing of the bench
    "aiohttp": ("screen/web.py",),
    "textual_serve": ("screen/web.py",),
    "numpy": ("check/",),  # whole logs at once; never in the tick, where the last bit would be a library's
    "pytest": ("pytest_plugin.py",),
}

# Each box of the picture, and what of ours it may build on.
FOUNDATION = {"bench.messages", "bench.config", "bench.errors"}
BUILDS_ON = {
    "errors.py": set(),
    "messages.py": set(),
    "config/checks.py": {
        "bench.config",
        "bench.errors",
        "bench.fittings",
        "bench.kinematics",
        "bench.ground.loads",
        "bench.messages",
        "bench.rc_decode",
        "bench.slamware.payloads",
    },
    "fittings.py": {"bench.config"},
    "sensors.py": FOUNDATION | {"bench.arena", "bench.fittings", "bench.slamware"},
    "ground/": FOUNDATION | {"bench.ground", "bench.kinematics"},
    "kinematics.py": FOUNDATION,
    "unwrap.py": FOUNDATION | {"bench.canbus.c610", "bench.ground.loads"},
    "wiring.py": FOUNDATION | {"bench.canbus"},
    "m2006.py": FOUNDATION | {"bench.canbus", "bench.unwrap", "bench.wiring"},
    "dm3519.py": FOUNDATION | {"bench.canbus", "bench.m2006"},
    "motors.py": FOUNDATION | {"bench.canbus", "bench.m2006", "bench.dm3519"},
    "canbus/": {"bench.canbus"},
    "instruments.py": FOUNDATION | {"bench.canbus", "bench.kinematics", "bench.m2006", "bench.unwrap"},
    "reckoning.py": FOUNDATION | {"bench.instruments", "bench.kinematics", "bench.m2006", "bench.odometry"},
    "controller.py": FOUNDATION | {"bench.kinematics", "bench.as_printed.choices"},  # the latter only when asked for
    "link.py": FOUNDATION,
    "odometry.py": FOUNDATION | {"bench.kinematics", "bench.as_printed.choices"},
    "drive.py": FOUNDATION | {"bench.kinematics", "bench.link"},
    "rc_decode.py": FOUNDATION | {"bench.rc"},
    "arena.py": FOUNDATION,
    "timed/": FOUNDATION | {"bench.timed", "bench.canbus", "bench.rc.line"},
    "noise.py": FOUNDATION,
    "hull.py": FOUNDATION | {"bench.arena", "bench.ground.loads"},
    "plant.py": FOUNDATION | {"bench.arena", "bench.ground", "bench.hull", "bench.kinematics"},
}


# Who may reach the documents' own formulas: who measures them, and who puts one into a run when its name is given.
PRINTED_FORMS_OPEN_TO = ("as_printed/", "errata/", "controller.py", "odometry.py")


@cache
def imported(tree):
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.append(node.module)
    return found


@pytest.mark.parametrize("package", ONLY_IN)
def test_only_the_right_door_opens_to(package):
    allowed = ONLY_IN[package]
    for name, tree in MODULES.items():
        if any(module.split(".")[0] == package for module in imported(tree)):
            assert name.startswith(allowed) if allowed else False, f"bench/{name} imports {package}"


@pytest.mark.parametrize("name", BUILDS_ON)
def test_boxes_build_on_what_lies_under_them(name):
    trees = [tree for path, tree in MODULES.items() if path == name or (name.endswith("/") and path.startswith(name))]
    assert trees
    for module in (module for tree in trees for module in imported(tree)):
        if module.split(".")[0] == "bench":
            assert any(module == one or module.startswith(one + ".") for one in BUILDS_ON[name]), f"{name}: {module}"


def test_printed_forms_are_kept_apart():
    for name, tree in MODULES.items():
        if not name.startswith(PRINTED_FORMS_OPEN_TO):
            assert not any(module.startswith("bench.as_printed") for module in imported(tree)), f"bench/{name}"
    run = "import sys, bench.loop; bench.loop.simulated(); print([n for n in sys.modules if 'as_printed' in n])"
    done = subprocess.run([sys.executable, "-c", run], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]", "a plain run loads none of them"


def test_the_loop_runs_without_a_screen_a_port_or_a_clock():
    heavy = "('textual', 'rich', 'can', 'serial', 'pytest', 'asyncio', 'bench.io', 'bench.check', 'bench.screen')"
    code = f"import sys, bench.loop; print([n for n in {heavy} if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_nobody_below_the_command_line_prints_or_exits():
    for name, tree in MODULES.items():
        if name.startswith(("cli/", "__main__", "pytest_plugin")):  # the doors
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in ("print", "exit", "input"), f"bench/{name} calls {node.func.id}"


def test_what_is_printed_for_people_goes_one_way():
    """`bench.cli.output.say` spells out what a name may hold; JSON does so itself, and stderr is told apart."""
    for name, tree in MODULES.items():
        if not name.startswith("cli/") or name == "cli/output.py":
            continue
        for call in ast.walk(tree):
            if not isinstance(call, ast.Call) or ast.unparse(call.func) != "print":
                continue
            is_json = isinstance(call.args[0], ast.Call) and ast.unparse(call.args[0].func) == "json.dumps"
            assert is_json or any(key.arg == "file" for key in call.keywords), f"bench/{name}: {ast.unparse(call)}"


def test_floats_are_not_summed_where_python_versions_differ():
    """Since 3.12 the built-in sum() of floats is compensated: another last bit than on 3.11."""
    for name in (
        "plant.py",
        "ground/contact.py",
        "ground/linear.py",
        "ground/loads.py",
        "ground/modes.py",
        "ground/sweeps.py",
        "ground/walls.py",
        "kinematics.py",
        "odometry.py",
        "instruments.py",
        "reckoning.py",
        "unwrap.py",
        "controller.py",
        "drive.py",
        "m2006.py",
        "dm3519.py",
    ):
        for node in ast.walk(MODULES[name]):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id != "sum", f"bench/{name} calls sum()"


def test_every_module_says_what_it_is():
    for name, tree in MODULES.items():
        assert ast.get_docstring(tree), f"bench/{name} has no docstring"
