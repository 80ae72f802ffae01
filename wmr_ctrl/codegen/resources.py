"""Location of the hand-written C: beside the package in a checkout, inside it in a wheel."""

from pathlib import Path

from wmr_ctrl.core.errors import WmrError

LAYOUTS = ("arduino", "platformio", "esp-idf", "zephyr")
"""Tools as whose libraries a package can be arranged."""
_PACKAGE = Path(__file__).resolve().parents[1]


def fmu_dir() -> Path:
    """Return the folder ``fmu/``, from the installed package or from the source tree.

    Raises WmrError if the installation lacks it.
    """
    for folder in (_PACKAGE / "_fmu", _PACKAGE.parent / "fmu"):
        if folder.is_dir():
            return folder
    raise WmrError(
        f"the C sources of wmr_ctrl are missing: neither {_PACKAGE / '_fmu'} nor "
        f"{_PACKAGE.parent / 'fmu'} exists. Install the package again."
    )


def runtime_dir() -> Path:
    """Return the folder of the C runtime (stepper, closed loop, noise): ``fmu/runtime``."""
    return fmu_dir() / "runtime"


def c_texts(*names: str, folder: str = "runtime") -> dict[str, str]:
    """Texts of files of a folder of ``fmu/``, by name."""
    return {name: (fmu_dir() / folder / name).read_text(encoding="utf-8") for name in names}
