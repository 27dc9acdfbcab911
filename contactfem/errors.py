"""The exceptions that a user may see, each with a message of one line."""


class ContactfemError(Exception):
    """Anything that contactfem has to say about why it cannot go on."""


class CaseError(ContactfemError):
    """A case file that cannot be run as it stands.

    The message reads "file: dotted.key = found: what is allowed; did you mean 'x'?".
    """


class MeshError(CaseError):
    """A mesh that cannot be used as it stands."""


class SolverError(ContactfemError):
    """The solver gave up; the last good state was kept."""
