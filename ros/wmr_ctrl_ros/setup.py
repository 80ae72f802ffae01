"""The package for colcon: entry points, launch files, parameters, a layout for Foxglove."""

from glob import glob

from setuptools import setup

NAME = "wmr_ctrl_ros"
SHARE = f"share/{NAME}"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (SHARE, ["package.xml"]),
        *((f"{SHARE}/{kind}", glob(f"{kind}/*")) for kind in ("launch", "config", "foxglove")),
    ],
    entry_points={
        "console_scripts": [f"{node} = {NAME}.nodes:run_{node}" for node in ("filter", "drive")]
    },
)
