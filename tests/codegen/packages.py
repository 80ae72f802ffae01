"""Packages of C in a folder, as `wmr-ctrl codegen` writes them."""

from wmr_ctrl.codegen.package import package_files
from wmr_ctrl.results import write_all


def write_package(law, out, scenario, *, float32=False):
    return write_all(package_files(law, scenario, float32=float32), out)
