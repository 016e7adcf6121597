"""MuJoCo with a graphics library that works on this machine."""

import os
import subprocess
import sys


def choose_gl() -> str:
    """Set MUJOCO_GL, unless it is set: EGL where a context can be made, else OSMesa.

    Must come before `import mujoco`. A trial process decides: a failed attempt cannot be undone in this one.
    """
    if "MUJOCO_GL" not in os.environ and "mujoco" not in sys.modules and sys.platform.startswith("linux"):
        trial = "import mujoco; context = mujoco.GLContext(8, 8); context.make_current(); context.free()"
        works = subprocess.run(
            [sys.executable, "-c", trial],
            env={**os.environ, "MUJOCO_GL": "egl"},
            capture_output=True,
            check=False,
        )
        os.environ["MUJOCO_GL"] = "egl" if works.returncode == 0 else "osmesa"
    return os.environ.get("MUJOCO_GL", "")


def load_mujoco():
    """The module mujoco, with the graphics library chosen."""
    choose_gl()
    import mujoco

    return mujoco
