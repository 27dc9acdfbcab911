"""Exceptions that a user may see, and exit codes."""

from enum import IntEnum


class ExitCode(IntEnum):
    """How the program ends."""

    DONE = 0
    MISSED = 1  # an expectation
    BAD_CASE = 2
    GAVE_UP = 3
    INTERRUPTED = 4  # by a signal; the state is written
    WRONG = 5  # what was found cannot be: it is not accepted
    BUG = 70


class ContactfemError(Exception):
    """Anything that contactfem has to say about why it cannot go on."""

    exit_code = ExitCode.GAVE_UP


class CaseError(ContactfemError):
    """A case file that cannot be run as it stands.

    The message has a line per mistake: "file: dotted.key = found: what is allowed; did you mean
    'x'?".
    """

    exit_code = ExitCode.BAD_CASE


class MeshError(CaseError):
    """A mesh that cannot be used as it stands."""


class SolverError(ContactfemError):
    """The solver gave up; the last good state was kept."""


class WriteError(ContactfemError):
    """Results cannot be written."""


class Interrupted(ContactfemError):
    """A signal ended the run after a whole step, and its state is written."""

    exit_code = ExitCode.INTERRUPTED


class CheckpointError(CaseError):
    """A run that cannot be resumed as it stands."""
