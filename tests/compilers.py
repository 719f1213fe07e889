"""Tests that compile a firmware: skipped, with what is missing, where there is no compiler."""

import shutil

import pytest

MISSING = [tool for tool in ("cc", "objcopy") if shutil.which(tool) is None]
needs_compiler = pytest.mark.skipif(bool(MISSING), reason=f"not on this machine: {', '.join(MISSING)} (gcc, binutils)")
