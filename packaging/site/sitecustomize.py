"""Make the checkout importable as the installed package would be, wherever Python is started.

`packaging/enter` puts this folder on PYTHONPATH. Sources come live from the checkout, the compiled
kernels from the cache.
"""

import os
import sys
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
KERNELS = os.environ.get("CONTACTFEM_KERNELS", "")
FOLDERS = {
    "contactfem": [str(CHECKOUT / "contactfem"), f"{KERNELS}/contactfem"],
    "contactfem.forms": [str(CHECKOUT / "forms")],
    "contactfem.meshes": [str(CHECKOUT / "meshes")],
}


class CheckoutFinder:
    """Finds contactfem and the two packages that live beside it in the checkout."""

    @staticmethod
    def find_spec(name: str, _path: object = None, _target: object = None) -> ModuleSpec | None:
        """Return where the package `name` is, or None for everything else."""
        if name not in FOLDERS:
            return None
        folders = FOLDERS[name]
        return spec_from_file_location(
            name, f"{folders[0]}/__init__.py", submodule_search_locations=folders
        )


# ahead of sys.path, where the working directory would offer contactfem without its parts
sys.meta_path.insert(0, CheckoutFinder)
