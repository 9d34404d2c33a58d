"""FMUs as `atlas fmu` writes them, and instances of them in FMPy."""

import shutil
import subprocess
from contextlib import contextmanager

import fmpy
import numpy as np
from fmpy.simulation import instantiate_fmu

from program import ATLAS


def write(manifest, out, *arguments):
    command = [ATLAS, "fmu", manifest, "--out", out, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True)


class Instance:
    """An instance of either version, by the names of its variables."""

    def __init__(self, file, folder=None, initialized=True, values=None, start=0.0):
        self.description = fmpy.read_model_description(str(file), validate=False)
        self.version = int(self.description.fmiVersion[0])
        self.folder = folder or fmpy.extract(str(file))
        self.fmu = instantiate_fmu(self.folder, self.description, "CoSimulation", logger=None)
        self.references = {own.name: own.valueReference for own in self.description.modelVariables}
        self.whole = {own.name for own in self.description.modelVariables if own.type in ("Integer", "Int64")}
        self.set(**(values or {}))
        if self.version == 2:
            self.fmu.setupExperiment(startTime=start)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start)
        if initialized:
            self.fmu.exitInitializationMode()

    def get(self, *names):
        values = []
        for name in names:
            kind = {(2, 0): "Real", (2, 1): "Integer", (3, 0): "Float64", (3, 1): "Int64"}
            get = getattr(self.fmu, "get" + kind[self.version, name in self.whole])
            values.append(get([self.references[name]])[0])
        return np.array(values)

    def set(self, **values):
        for name, value in values.items():
            name = name.replace("__", ".")
            set_ = self.fmu.setReal if self.version == 2 else self.fmu.setFloat64
            set_([self.references[name]], [value])

    def rate(self, **values):
        for name, value in values.items():
            self.fmu.setRealInputDerivatives([self.references[name.replace("__", ".")]], [1], [value])

    def steps(self, count, length, first=0, names=("mesh.deflection",)):
        rows = []
        for step in range(first, first + count):
            self.fmu.doStep(step * length, length)
            rows.append(self.get(*names))
        return np.array(rows)

    def call(self, name):
        """A function for states, which the two versions spell in two ways."""
        return getattr(self.fmu, name.replace("#", "FMUstate" if self.version == 2 else "FMUState"))


@contextmanager
def instance(file, **options):
    own = Instance(file, **options)
    try:
        yield own
    finally:
        own.fmu.freeInstance()
        if "folder" not in options:
            shutil.rmtree(own.folder, ignore_errors=True)
