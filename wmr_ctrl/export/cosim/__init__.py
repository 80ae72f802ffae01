"""Co-simulation of FMUs, ours or foreign ones, into a Run."""

from wmr_ctrl.core.errors import MissingExtraError

try:
    import fmpy as fmpy  # and the libraries that it loads
except (ImportError, OSError) as error:
    raise MissingExtraError(
        f"this needs FMPy, which cannot be imported ({error}): pip install --force-reinstall fmpy."
    ) from None

from .run import cosimulate as cosimulate
