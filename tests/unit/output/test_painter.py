"""Pictures that another process draws, and what a run imports itself."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from contactfem.output.figures.painter import Painter

ROOT = Path(__file__).parents[3]
# what is for pictures, tables and meshes that a run of the block does not make itself
NOT_FOR_A_RUN = {
    "matplotlib",
    "pyvista",
    "vtkmodules",
    "gmsh",
    "meshio",
    "rich",
    "pandas",
    "IPython",
}


def test_the_other_process_draws(make_run, tmp_path, monkeypatch):
    def here(*_):
        raise AssertionError("drawn in this process")

    monkeypatch.setattr("contactfem.output.figures.all_figures.draw_all", here)
    Painter().draw(make_run(), tmp_path)
    assert {"interface_sole.png", "convergence.png"} <= {path.name for path in tmp_path.iterdir()}


def test_what_cannot_be_sent_is_drawn_here(make_run, tmp_path):
    run = make_run()
    run = replace(run, probes={"tip": lambda: 0.0})  # no function of a test can be pickled
    Painter().draw(run, tmp_path)
    assert (tmp_path / "interface_sole.png").exists()


def test_without_a_result_it_ends():
    painter = Painter()
    painter.close()
    assert painter._process.returncode == 0


def test_a_run_imports_only_what_it_needs(tmp_path):
    words = f"['run', 'cases/block.toml', '--out', {str(tmp_path)!r}]"
    program = (
        f"import sys; from contactfem.cli.main import main; assert main({words}) == 0; "
        "print(*{name.split('.')[0] for name in sys.modules}, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert NOT_FOR_A_RUN.isdisjoint(done.stderr.split())


def test_a_process_that_died_is_made_up_for(make_run, tmp_path):
    painter = Painter()
    painter._process.kill()
    painter._process.wait()
    painter.draw(make_run(), tmp_path)
    assert (tmp_path / "interface_sole.png").exists()
