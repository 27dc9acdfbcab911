"""Text for people."""

from pathlib import Path

import pytest

from contactfem.common.text import about, nearest, one_line, percent, shortened, similar
from contactfem.errors import CaseError, MeshError


def test_hints():
    names = ["bulk_modulus", "shear_modulus", "density"]
    assert similar("bulk_modulu", names) == "; did you mean 'bulk_modulus'?"
    assert similar("xyz", names) == ""
    assert nearest("densiti", iter(names)) == "; did you mean 'density'?"
    assert nearest("xyz", names) == "; known: bulk_modulus, shear_modulus, density"
    assert nearest("xyz", []) == ""
    assert nearest("?", [f"n{k}" for k in range(40)]).endswith(", n11")


def test_percent():
    assert percent(0.0321456) == "3.21 %"
    assert percent(0.0321456, 2) == "3.2 %"
    assert percent(1.0) == "100 %"


def test_the_middle_of_many_is_left_out():
    assert shortened([1, 2, 3, 4], 4) == [1, 2, 3, 4]
    assert shortened([1, 2, 3, 4, 5], 4) == [1, 2, None, 4, 5]
    assert shortened([], 4) == []


def test_a_line_shows_what_a_terminal_would_obey():
    assert one_line("a\nb\x1b[31m") == "a\\nb\\x1b[31m"


def test_every_line_of_an_error_is_about_its_file():
    with pytest.raises(MeshError) as found, about(Path("a.toml")):
        raise MeshError("no such surface\na.toml: nor this\tone")
    assert str(found.value) == "a.toml: no such surface\na.toml: nor this\\tone"
    with pytest.raises(ValueError, match="not about a case"), about(Path("a.toml")):
        raise ValueError("not about a case")
    with pytest.raises(CaseError, match=r"^b.toml: x$"), about(Path("b.toml")):
        raise CaseError("x")
