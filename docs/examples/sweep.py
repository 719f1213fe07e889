"""How slippery may the floor be, and how late the commands, before the robot does not stop any more as it should?"""

from dataclasses import replace

from bench.scenarios import load_robot, run, run_many

DRIVE = {
    "seconds": 2.5,
    "stick": [{"at_s": 0.2, "aux1": True}, {"at_s": 0.3, "forward": 0.6}, {"at_s": 1.5}],
    "expect": [{"name": "stops", "when": "t_s >= 2.0", "then": "speed_mps < 0.02"}],
}


def floors():
    robot = load_robot("m2006")
    for grip in (0.7, 0.2, 0.1):
        result = run(name=f"grip {grip}", robot=replace(robot, ground=replace(robot.ground, grip=grip)), **DRIVE)
        print(f"{result.name:12} {result.summary['path_m']:.3f} m  {result.verdicts[0].text}")


def delays():
    late = [
        {"name": f"{ms} ms late", "fault": [{"wire": "command", "kind": "delay", "ms": ms, "at_s": 0.0}], **DRIVE}
        for ms in (2, 10, 40)
    ]
    for result in run_many(late, jobs=2):
        print(f"{result.name:12} {result.summary['path_m']:.3f} m  {result.verdicts[0].text}")


if __name__ == "__main__":
    floors()
    delays()
