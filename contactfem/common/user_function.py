"""A user's function, named "file.py:function" in a case file."""

import importlib.util
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contactfem.errors import CaseError

PATTERN = r"^[^:]+\.py:[A-Za-z_]\w*$"


@dataclass(frozen=True)
class FunctionRef:
    """Names a function: its file, relative to the case file, and its name there."""

    file: str
    name: str

    def __str__(self) -> str:
        """As it stands in a case file."""
        return f"{self.file}:{self.name}"

    @property
    def times(self) -> tuple[float, ...]:
        """Times at which its values are known to have a kink: none."""
        return ()

    @property
    def values(self) -> tuple[float, ...]:
        """Values that are known without calling it: none."""
        return ()

    def load(self, folder: Path) -> Callable[..., Any]:
        """The function.

        Args:
            folder: Folder of the case file.

        Returns:
            What the file defines under that name.

        Raises:
            CaseError: No such file, the file cannot be run, or it has no such function.
        """
        path = folder / self.file
        spec = importlib.util.spec_from_file_location(path.stem, path)
        if spec is None or spec.loader is None or not path.is_file():
            raise CaseError(f"{self}: there is no file {path}")
        module = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            kind = type(error).__name__
            raise CaseError(f"{self}: {path} cannot be run: {kind}: {error}") from None
        function = getattr(module, self.name, None)
        if not callable(function):
            raise CaseError(f"{self}: there is no function '{self.name}' in {path}")
        found: Callable[..., Any] = function
        return found


def is_reference(text: object) -> bool:
    """Whether a text is of the form "file.py:function"."""
    return isinstance(text, str) and re.match(PATTERN, text) is not None


def reference(text: str) -> FunctionRef:
    """Function that a text "file.py:function" names."""
    file, _, name = text.rpartition(":")
    return FunctionRef(file, name)
