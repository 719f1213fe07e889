"""Robots and transmitters as data: TOML files in, validated frozen values out.

Every geometry, limit, gain and timeout of the bench is a named number in a robot file (`bench/robots/*.toml`, or the
user's own); every transmitter is a profile (`bench/profiles/*.toml`, or the user's own). A file that cannot be right is
refused here, with one sentence that names file, key and the nearest valid choice, so that nothing behind this door has
to check again. Degrees exist only in the files; from here on angles are radians.

    values   what a robot and a transmitter are          table    one TOML table, every refusal with file and key
    files    where they lie, tables -> values            checks   whether the whole can be
"""

from bench.config.checks import check_robot
from bench.config.files import (
    PROFILES_DIR,
    ROBOTS_DIR,
    load_profile,
    load_robot,
    profile_names,
    profile_path,
    robot_names,
    robot_path,
    with_choices,
)
from bench.config.table import ConfigError, Table, nearest, read_toml
from bench.config.values import (
    CONTROL_KINDS,
    EXACT,
    ODOMETRY_FORMS,
    PROTOCOLS,
    SLAMWARE_CHOICES,
    SPEED_LOOP,
    Axis,
    Body,
    Button,
    Control,
    Dm3519,
    Ground,
    Gyro,
    Limits,
    LinkLimits,
    Motor,
    Profile,
    Robot,
    SlamwareSettings,
    Wheel,
)

__all__ = [
    "CONTROL_KINDS",
    "EXACT",
    "ODOMETRY_FORMS",
    "PROFILES_DIR",
    "PROTOCOLS",
    "ROBOTS_DIR",
    "SLAMWARE_CHOICES",
    "SPEED_LOOP",
    "Axis",
    "Body",
    "Button",
    "ConfigError",
    "Control",
    "Dm3519",
    "Ground",
    "Gyro",
    "Limits",
    "LinkLimits",
    "Motor",
    "Profile",
    "Robot",
    "SlamwareSettings",
    "Table",
    "Wheel",
    "check_robot",
    "load_profile",
    "load_robot",
    "nearest",
    "profile_names",
    "profile_path",
    "read_toml",
    "robot_names",
    "robot_path",
    "with_choices",
]
