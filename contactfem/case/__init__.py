"""What a case file may say, read, checked, in SI."""

from contactfem.case.read import case_of, read_case
from contactfem.case.schema import Case

__all__ = ["Case", "case_of", "read_case"]
