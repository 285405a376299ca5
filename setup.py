"""The packages of the wheel: those of avahazard/, with migrations/ and data/ inside it."""

from setuptools import find_packages, setup

BESIDE = {"avahazard.migrations": "migrations", "avahazard.data": "data"}

setup(
    packages=[
        *find_packages(include=["avahazard", "avahazard.*"]),
        *BESIDE,
        *(f"{name}.{part}" for name, folder in BESIDE.items() for part in find_packages(folder)),
    ],
    package_dir=BESIDE,
)
