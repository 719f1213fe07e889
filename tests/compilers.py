"""Tests that compile a firmware: skipped, with what is missing, where there is no compiler."""

import shutil

import pytest

MISSING = [tool for tool in ("cc", "objcopy") if shutil.which(tool) is None]
HOW_TO_GET_THEM = f"no {' and no '.join(MISSING)} on this machine: apt-get install gcc libc6-dev binutils"
needs_compiler = pytest.mark.skipif(bool(MISSING), reason=HOW_TO_GET_THEM)
