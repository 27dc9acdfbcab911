"""What mkdocs does for the documentation besides Markdown: formulas, and files beside docs/.

Formulas become MathML when the site is built, so that pages need no script and no network.
"""

import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
CODE_OR_FORMULA = re.compile(
    r"(?P<code>^```.*?^```|`[^`\n]+`)|\$\$(?P<block>.+?)\$\$|\$(?P<line>[^$\n]+)\$",
    re.DOTALL | re.MULTILINE,
)
BESIDE = re.compile(r"\]\(\.\./(cases/)")
FORMULA = "formula{}x"  # what stands for one while Markdown is read

formulas: list[str] = []


def on_files(files: Files, config: Any) -> Files:
    """Put the case files into the site, so that links to them work there as in the checkout."""
    for path in sorted(ROOT.glob("cases/**/*.toml")):
        name = path.relative_to(ROOT).as_posix()
        files.append(File.generated(config, name, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Take the formulas out and let links find the case files."""
    formulas.clear()
    return CODE_OR_FORMULA.sub(_formula, BESIDE.sub(r"](\1", markdown))


def _formula(found: re.Match[str]) -> str:
    if found["code"]:
        return found["code"]
    text, display = (found["block"], "block") if found["block"] else (found["line"], "inline")
    formulas.append(convert(text.strip(), display=display))
    return FORMULA.format(len(formulas) - 1)


def on_page_content(html: str, **_: Any) -> str:
    """Put the formulas back."""
    return re.sub(FORMULA.format(r"(\d+)"), lambda found: formulas[int(found[1])], html)
