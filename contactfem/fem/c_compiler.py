"""The C compiler that compiles forms during a run."""

import os
import shlex
import shutil
import sys
import sysconfig
from importlib.util import find_spec

USUAL = ("cc", "gcc", "clang")


def ensure_compiler() -> None:
    """Let CC name a C compiler that is there: Python's own, a usual one, or that of `ziglang`.

    An environment of pip alone has the last. Where there is none at all, CC stays as it is: what is
    compiled already runs, and what is not says what could not be called.
    """
    given = os.environ.get("CC") or sysconfig.get_config_var("CC") or USUAL[0]
    if "CC" in os.environ or shutil.which(shlex.split(given)[0]):
        return
    there = [name for name in USUAL if shutil.which(name)]
    if there:
        os.environ["CC"] = there[0]
    elif find_spec("ziglang") is not None:
        os.environ["CC"] = f"{shlex.quote(sys.executable)} -m ziglang cc"
